#include <chrono>
#include <csignal>

#include "components/roles.h"

namespace rubicon::bench {

/// The owner of a tuple. It ends its watcher by a signal two seconds after the demand began, and waits for the end of
/// it.
Json watched(const Meeting& meeting, const Json& options) {
  Node node(kFirst, meeting);
  (void)node.space().set(load_key(0), value_of(0));
  Json unwanted;  // null: there was no demand, or it did not end
  double ended = 0;
  base::Timer end;
  const auto demand = node.space().watch_demand({kFirst, load_key(0)}, [&](const tuples::Demand& now) {
    if (now.wanted && !end.pending() && ended == 0) {
      end = node.scheduler().after(std::chrono::seconds(2), [&] {
        ended = wall_seconds();
        ::kill(options.at("watcher").get<pid_t>(), options.at("signal").get<int>());
      });
    }
    if (now.wanted || ended == 0) return;
    unwanted = wall_seconds() - ended;
    node.finish();
  });
  node.run(std::chrono::minutes(2));
  return {{"unwanted_s", unwanted}};
}

Json watcher(const Meeting& meeting, const Json&) {
  Node node(kSecond, meeting);
  const auto all = node.space().subscribe({kFirst, "**"}, {}, [](const tuples::Event&) {});
  node.run(std::chrono::minutes(2));
  return Json::object();
}

}  // namespace rubicon::bench
