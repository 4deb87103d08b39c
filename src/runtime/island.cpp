#include "runtime/island.h"

#include <fmt/format.h>

#include "proxy/proxy.h"

namespace rubicon::runtime {

/// In the order of construction: what stands further down uses what stands above.
struct Island::Parts {
  Parts(IslandConfig some_config, std::unique_ptr<tuples::Link> a_link, Scheduler& scheduler,
        transport::Transports& transports, base::LogSink& log)
      : config(std::move(some_config)),
        link(std::move(a_link)),
        space(config.id, scheduler, *link),
        gateway(scheduler, space, log, config.limits),
        proxy(config.proxy, scheduler, space, gateway, config.types, log),
        networks(config.id, scheduler, transports, log, gateway) {
    gateway.connect(networks);
    for (const auto& setup : config.recorders) {
      recorders.push_back(std::make_unique<Recorder>(
          setup, Recorder::Place{scheduler, space, transports, log, config.proxy.prefix, config.directory}));
    }
  }

  IslandConfig config;
  std::unique_ptr<tuples::Link> link;
  TupleSpace space;
  std::vector<std::unique_ptr<Recorder>> recorders;
  gateway::Gateway gateway;
  proxy::Proxy proxy;
  network::Supervisor networks;
};

Island::Island(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Island::~Island() = default;

Result<std::unique_ptr<Island>> Island::make(IslandConfig config, Scheduler& scheduler,
                                             transport::Transports& transports, base::LogSink& log,
                                             tuples::MemoryEcology& ecology, base::ConfigErrors& errors) {
  auto link = ecology.join(config.id);
  if (!link) return fail(link.error());
  auto parts = std::make_unique<Parts>(std::move(config), std::move(*link), scheduler, transports, log);
  for (auto& setup : parts->config.networks) {
    if (!setup.type) continue;
    ConfigReader options(setup.options, "networks." + setup.key, errors);
    const auto before = errors.lines().size();
    const auto added = parts->networks.add(
        *setup.type, {setup.id, parts->config.id, options, parts->config.types, parts->config.directory});
    if (!added && errors.lines().size() == before) options.error("", added.error().text);
    options.finish();
  }
  if (!errors.empty()) return fail(ErrorCode::kInvalid, errors.text());
  return std::unique_ptr<Island>(new Island(std::move(parts)));
}

void Island::start() {
  for (auto& recorder : parts_->recorders) recorder->start();
  parts_->networks.start();
}

TupleSpace& Island::space() {
  return parts_->space;
}
gateway::Gateway& Island::gateway() {
  return parts_->gateway;
}
network::Supervisor& Island::networks() {
  return parts_->networks;
}
const std::vector<std::unique_ptr<Recorder>>& Island::recorders() const {
  return parts_->recorders;
}
const IslandConfig& Island::config() const {
  return parts_->config;
}

}  // namespace rubicon::runtime
