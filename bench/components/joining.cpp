#include <fmt/format.h>

#include "components/report.h"
#include "components/roles.h"

namespace rubicon::bench {

namespace {

/// Runs until so many events came.
struct Count {
  Node& node;
  int expected;
  int came = 0;
  void operator()(const tuples::Event&) {
    if (++came == expected) node.finish();
  }
};

}  // namespace

/// An island with 100,000 tuples, until `joiners` others came and went.
Json island(const Meeting& meeting, const Json& options) {
  Node node(kFirst, meeting);
  for (int device = 0; device < kJoinedDevices; ++device) {
    for (int sensor = 0; sensor < kJoinedSensors; ++sensor)
      (void)node.space().set(fmt::format("proxy.wsn-1.device-{}.sensor.light-{}.value", device, sensor), value_of(1));
  }
  for (int i = options.at("joiners"); i > 0; --i) node.await_end_of(kSecond);
  return Json::object();
}

Json joiner(const Meeting& meeting, const Json& options) {
  const auto start = std::chrono::steady_clock::now();
  Node node(kSecond, meeting);
  node.await(kFirst);
  const auto subscribed = node.scheduler().now();
  Count count{node, options.at("expected")};
  const auto all = node.space().subscribe({kFirst, options.at("pattern").get<std::string>()}, {}, std::ref(count));
  node.run(std::chrono::minutes(1));
  const auto end = node.scheduler().now();
  return {{"seconds", seconds_between(subscribed, end)}, {"with_start", seconds_between(start, end)}};
}

}  // namespace rubicon::bench
