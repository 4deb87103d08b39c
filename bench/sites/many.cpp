#include <algorithm>
#include <chrono>
#include <set>
#include <vector>

#include "client/points.h"
#include "frame/connection_figures.h"
#include "sites/engine.h"
#include "sites/measurements.h"
#include "sites/site.h"

namespace rubicon::bench::sites {

namespace {

constexpr OwnerId kLister{1'070'010}, kSwitcher{1'070'011};

/// A site with a connection of its own, though others share the process.
struct LinkedSite {
  LinkedSite(OwnerId id, const Meeting& meeting, int devices, transport::Loop& loop, base::LogSink& log)
      : ecology(open_at_broker(meeting, loop, log)),
        link(std::move(*ecology->join(id))),
        space(id, loop.scheduler(), *link),
        site(space, devices) {}

  std::shared_ptr<tuples::Ecology> ecology;
  std::unique_ptr<tuples::Link> link;
  TupleSpace space;
  Site site;
};

/// What a newcomer did from its start on.
Json newcomer(Clock::time_point start) {
  const auto passed = passed_on_connections();
  return {{"seconds", rounded(seconds_since(start), 3)}, {"bytes", passed.received + passed.sent}};
}

}  // namespace

/// Until it is ended.
Json many_sites(const Meeting& meeting, const Json& options) {
  transport::Loop loop;
  base::NullLogSink log;
  std::vector<std::unique_ptr<LinkedSite>> all;
  const auto first = options.at("first").get<std::uint32_t>(), count = options.at("count").get<std::uint32_t>();
  for (std::uint32_t i = 0; i < count; ++i)
    all.push_back(std::make_unique<LinkedSite>(OwnerId(first + i), meeting, options.at("devices"), loop, log));
  loop.run();
  return Json::object();
}

/// Lists all devices that measure a temperature, as `rubicon devices` does, until it has so many.
Json lister(const Meeting& meeting, const Json& options) {
  const auto start = Clock::now();
  const std::size_t expected = options.at("expected");
  Node node(kLister, meeting);
  std::set<std::pair<OwnerId, std::string>> found;
  client::DeviceQuery thermometers;
  thermometers.type = "temperature";
  const client::DeviceWatch watch(node.space(), thermometers, [&](const client::Device& device, bool present) {
    if (present && found.emplace(device.island, device.key()).second && found.size() == expected) node.finish();
  });
  node.rest(std::chrono::seconds(options.at("patience_s").get<int>()));
  auto result = newcomer(start);
  result["found"] = found.size();
  result["processor_s"] = rounded(own_processor_seconds(), 2);
  return result;
}

/// Switches a lamp of a site that it knows by its id alone.
Json switcher(const Meeting& meeting, const Json& options) {
  const auto start = Clock::now();
  const OwnerId island{options.at("island").get<std::uint32_t>()};
  Node node(kSwitcher, meeting);
  node.await(island);
  node.space().set_remote(island, Site::lamp_command(), "on", std::chrono::seconds(10),
                          [&](const tuples::Reply& reply) {
                            if (reply.verdict != tuples::Verdict::kApplied)
                              give_up("a lamp was not switched: " + reply.text);
                            node.finish();
                          });
  node.run(std::chrono::seconds(20));
  return newcomer(start);
}

}  // namespace rubicon::bench::sites
