#include "bench/short_run.h"

namespace rubicon {
namespace {

class BenchOfSites : public testing::TestWithParam<Measurement> {};

TEST_P(BenchOfSites, ShortRunMeasuresAllAndLosesNothing) {
  short_run("rubicon-bench-sites", GetParam());
}

INSTANTIATE_TEST_SUITE_P(
    All, BenchOfSites,
    testing::Values(Measurement{"latency", {"set_to_callback_us", "bare_ping_us", "latency_ratio"}, {}},
                    Measurement{"throughput", {"tuples_per_second", "stale_copies", "broker_us_per_tuple"}, {}},
                    Measurement{"remote-sets", {"remote_sets_per_second"}, {"remote_set_faults"}},
                    Measurement{"join", {"join_100000_s"}, {}},
                    Measurement{"idle", {"idle_island_bytes_per_second"}, {}},
                    Measurement{"reading", {"a_watched_reading"}, {}},
                    Measurement{"restarts",
                                {"stream_goes_on_s"},
                                {"commands_twice", "commands_late", "applied_but_not_executed", "lost_final_values"}},
                    Measurement{"death", {"owner_learns_of_killed_s"}, {}}, Measurement{"crowd", {"all_see_all_s"}, {}},
                    Measurement{"sites", {"sites"}, {}}));

}  // namespace
}  // namespace rubicon
