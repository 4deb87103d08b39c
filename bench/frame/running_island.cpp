#include "frame/running_island.h"

#include <functional>
#include <stdexcept>

#include "config/yaml.h"
#include "island/network_types.h"

namespace rubicon::bench {

base::NullLogSink& nowhere() {
  static base::NullLogSink log;
  return log;
}

void must(const Result<void>& result) {
  if (!result) throw std::runtime_error(result.error().text);
}

std::unique_ptr<island::Island> start_island(const std::string& yaml, Scheduler& scheduler,
                                             transport::Transports& transports, tuples::Ecology& ecology,
                                             std::unique_ptr<state::StateStore> state) {
  base::ConfigErrors errors;
  auto config =
      island::read_island_config(must(config::parse_yaml(yaml, "bench.yaml")), island::network_types(), errors);
  if (!errors.empty()) throw std::runtime_error(errors.text());
  auto made =
      island::Island::make(std::move(config), scheduler, transports, nowhere(), ecology, errors, std::move(state));
  if (!errors.empty()) throw std::runtime_error(errors.text());
  auto island = must(std::move(made));
  island->start();
  return island;
}

Component::Component(tuples::Ecology& ecology, Scheduler& scheduler, std::uint32_t id)
    : link_(must(ecology.join(OwnerId(id)))), space_(std::make_unique<TupleSpace>(OwnerId(id), scheduler, *link_)) {}

std::unique_ptr<tuples::dds::DdsEcology> join_on_loopback(std::uint32_t domain, Scheduler& scheduler) {
  tuples::dds::DdsOptions options;
  options.domain = domain;
  options.interfaces = {"lo"};
  const auto post = [&scheduler](std::function<void()> call) { scheduler.post(std::move(call)); };
  return must(tuples::dds::DdsEcology::open(options, scheduler, post, nowhere()));
}

}  // namespace rubicon::bench
