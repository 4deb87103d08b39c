#include <fmt/format.h>
#include <malloc.h>

#include "components/roles.h"
#include "ecology/measurements.h"
#include "island/spare_memory.h"

namespace rubicon::bench {

namespace {

constexpr std::uint32_t kFirstVisitor = 1'080'000;
constexpr int kVisitorTuples = 500, kWarmUp = 100;

/// Of the main arena, where the loop allocates.
double allocated_mb() {
  const auto all = ::mallinfo2();
  return static_cast<double>(all.uordblks + all.hblkhd) / 1e6;
}

double resident_at(const Json& stays, int visits) {
  for (const auto& one : stays) {
    if (one.at("visits") == visits) return one.at("resident_mb");
  }
  return 0;
}

}  // namespace

/// An owner of tuples that stays while other components come and go; measures its memory in steps.
Json keeper(const Meeting& meeting, const Json& options) {
  const int visits = options.at("visits"), step = options.at("step");
  Node node(kFirst, meeting);
  for (int i = 0; i < kVisitorTuples; ++i)
    (void)node.space().set(fmt::format("proxy.hall.sensor.light-{}.value", i), value_of(0));
  const auto policy = node.space().add_policy({kFirst, "command"},
                                              [](const tuples::RemoteSet&) { return tuples::SetDecision::applied(); });
  const island::SpareMemory spare_memory(node.scheduler());  // as an island has it
  Json stays = Json::array();
  int gone = 0;
  const auto watch = node.space().watch_peers([&](OwnerId, tuples::PeerEvent event) {
    if (event == tuples::PeerEvent::kUp) return;
    if (++gone % step == 0)
      stays.push_back({{"visits", gone}, {"resident_mb", resident_mb()}, {"allocated_mb", allocated_mb()}});
    if (gone == visits) node.finish();
  });
  node.run(std::chrono::minutes(60));
  return stays;
}

/// Runs components one after the other, each like a CLI command: reads all, sets one tuple, leaves.
Json visitors(const Meeting& meeting, const Json& options) {
  const int visits = options.at("visits");
  for (int i = 0; i < visits; ++i) {
    Node node(OwnerId(kFirstVisitor + static_cast<std::uint32_t>(i)), meeting);
    node.await(kFirst);
    int left = 2;
    const auto one_less = [&] {
      if (--left == 0) node.finish();
    };
    const auto all = node.space().subscribe(
        {kFirst, "proxy.**"}, {}, [](const tuples::Event&) {}, [&](OwnerId) { one_less(); });
    node.space().set_remote(kFirst, "command", "x", std::chrono::seconds(20),
                            [&](const tuples::Reply&) { one_less(); });
    node.run(std::chrono::seconds(30));
  }
  return {{"visits", visits}};
}

void measure_churn(const Plan& plan, Report& report) {
  const int visits = plan.is_quick ? 2 * kWarmUp : 6 * kWarmUp;
  const Json options{{"visits", visits}, {"step", kWarmUp}};
  const auto meeting = plan.new_meeting();
  auto staying = start_role("keeper", meeting, options);
  auto coming = start_role("visitors", meeting, options);
  (void)result_of(coming);
  const auto stays = result_of(staying);
  const auto grown = rounded(resident_at(stays, visits) - resident_at(stays, kWarmUp), 2);
  report.figure("churn_grown_mb", grown);
  report.target("churn_grown_mb", "under 1", grown < 1);
  report.detail("churn_grown_mb",
                {{"method",
                  "growth of the resident memory of an owner of 500 tuples from the 100th to the last of so many "
                  "components that came one after the other, subscribed to all, set one tuple and left"},
                 {"visits", visits},
                 {"stays", stays}});
}

}  // namespace rubicon::bench
