#include <chrono>

#include "components/roles.h"

namespace rubicon::bench {

/// The owner of a tuple until the demand for it ended.
Json watched(const Meeting& meeting, const Json&) {
  Node node(kFirst, meeting);
  (void)node.space().set(load_key(0), value_of(0));
  bool wanted = false;
  const auto demand = node.space().watch_demand({kFirst, load_key(0)}, [&](const tuples::Demand& now) {
    if (wanted && !now.wanted) node.finish();
    wanted = now.wanted;
  });
  node.run(std::chrono::minutes(2));
  return {{"unwanted", wall_seconds()}};
}

Json watcher(const Meeting& meeting, const Json&) {
  Node node(kSecond, meeting);
  const auto all = node.space().subscribe({kFirst, "**"}, {}, [](const tuples::Event&) {});
  node.run(std::chrono::minutes(2));
  return Json::object();
}

}  // namespace rubicon::bench
