#include <fmt/format.h>
#include <malloc.h>

#include "components/roles.h"
#include "ecology/measurements.h"

namespace rubicon::bench {

namespace {

constexpr int kMemoryTuples = 1'000'000, kTaken = 10'000, kUpdates = 10;

std::string mass_key(int index) {
  return fmt::format("proxy.wsn-{}.device-{}.sensor.light-{}.value", index / kTaken, index / 10 % 1000, index % 10);
}

double heap_mb() {
  const auto all = ::mallinfo2();
  return static_cast<double>(all.uordblks + all.hblkhd) / 1e6;
}

}  // namespace

Json holder(const Meeting& meeting, const Json&) {
  Node node(kFirst, meeting);
  for (int i = 0; i < kMemoryTuples; ++i) (void)node.space().set(mass_key(i), value_of(0));
  int steps = 0;
  base::Timer rest;
  const auto pause = [&] {
    rest = node.scheduler().after(std::chrono::seconds(1), [&] { node.finish(); });
    node.run(std::chrono::minutes(1));
  };
  pause();
  ::malloc_trim(0);  // what making the tuples left free must not hide what comes
  const auto resident = resident_mb(), allocated = heap_mb();
  const auto ready = node.space().subscribe({kSecond, "bench.ready"}, {}, [&](const tuples::Event&) {
    ++steps;
    node.finish();
  });
  (void)node.space().set("bench.go", "yes");
  if (steps == 0) node.run(std::chrono::minutes(1));
  pause();
  const auto quiet_resident = resident_mb(), quiet_allocated = heap_mb();
  for (int update = 1; update <= kUpdates; ++update) {
    for (int i = 0; i < kTaken; ++i) (void)node.space().set(mass_key(7 * kTaken + i), value_of(1));
    rest = node.scheduler().after(std::chrono::milliseconds(100), [&] { node.finish(); });
    node.run(std::chrono::minutes(1));
  }
  const auto busy_resident = resident_mb();
  (void)node.space().set("bench.done", "yes");
  node.await_end_of(kSecond);
  return {{"resident_mb_nobody", rounded(resident, 1)},
          {"resident_grown_mb", rounded(quiet_resident - resident, 2)},
          {"resident_grown_mb_after_updates", rounded(busy_resident - resident, 2)},
          {"allocated_grown_mb", rounded(quiet_allocated - allocated, 2)}};
}

/// Subscribes to one hundredth of it, when told to.
Json taker(const Meeting& meeting, const Json&) {
  Node node(kSecond, meeting);
  node.await(kFirst);
  auto go = node.space().subscribe({kFirst, "bench.go"}, {}, [&](const tuples::Event&) { node.finish(); });
  node.run(std::chrono::minutes(2));
  int came = 0;
  const auto some = node.space().subscribe({kFirst, "proxy.wsn-7.**"}, {}, [&](const tuples::Event&) {
    if (++came == kTaken) (void)node.space().set("bench.ready", "yes");
  });
  const auto done = node.space().subscribe({kFirst, "bench.done"}, {}, [&](const tuples::Event&) { node.finish(); });
  node.run(std::chrono::minutes(2));
  return {{"taken", came}};
}

void measure_memory(const Plan& plan, Report& report) {
  std::vector<double> grown;
  Json rounds = Json::array();
  for (int round = 0; round < (plan.is_quick ? 1 : 3); ++round) {
    const auto meeting = plan.new_meeting();
    auto owning = start_role("holder", meeting, Json::object());
    auto taking = start_role("taker", meeting, Json::object());
    (void)result_of(taking);
    const auto run = result_of(owning);
    grown.push_back(
        std::max(run.at("resident_grown_mb").get<double>(), run.at("resident_grown_mb_after_updates").get<double>()));
    rounds.push_back(run);
  }
  const auto mb = rounded(median(grown), 2);
  report.figure("owner_dds_mb", mb);
  report.target("owner_dds_mb", "under 20", mb < 20);
  report.detail("owner_dds_mb",
                {{"method",
                  "growth of the owner's resident memory (everything, not DDS alone) from 1,000,000 tuples with nobody "
                  "subscribed to 10,000 of them subscribed by another process, after the initial values and after ten "
                  "updates of each, the larger; allocated: mallinfo2 of the main arena"},
                 {"rounds", rounds}});
}

}  // namespace rubicon::bench
