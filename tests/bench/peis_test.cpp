#include "bench/short_run.h"

namespace rubicon {
namespace {

class BenchOfPeis : public testing::TestWithParam<Measurement> {};

TEST_P(BenchOfPeis, ShortRunMeasuresAllAndLosesNothing) {
  short_run("rubicon-bench-peis", GetParam());
}

TEST(BenchOfPeisAlone, RefusesToMeasureABuildThatIsNotOptimised) {
#ifdef NDEBUG
  GTEST_SKIP() << "this build is optimised";
#endif
  const auto run = support::run_to_end({RUBICON_BINARY_DIR "/bin/rubicon-bench-peis", "--only", "latency"});
  EXPECT_EQ(run.code, 2);
  EXPECT_THAT(run.errors, testing::HasSubstr("cmake --build --preset install --target rubicon-bench-peis"));
  EXPECT_EQ(run.output, "");
}

INSTANTIATE_TEST_SUITE_P(
    All, BenchOfPeis,
    testing::Values(
        Measurement{"latency", {"set_to_callback_us", "bare_ping_us", "latency_ratio"}, {}},
        Measurement{"throughput", {"tuples_per_second", "bare_per_second", "processor_us_per_tuple"}, {"lost_tuples"}},
        Measurement{"remote-sets", {"remote_sets_per_second"}, {"remote_set_faults"}},
        Measurement{"join", {"join_100000_s"}, {}}, Measurement{"stall", {"right_after_stall_s"}, {}},
        Measurement{"death", {"owner_learns_of_killed_s", "owner_learns_of_stopped_s"}, {}},
        Measurement{"crowd", {"all_see_all_s", "idle_cpu_percent", "newcomer_sees_all_s"}, {}},
        Measurement{"kernel", {"kernel_missing_at_3000"}, {"kernel_stale_at_20000"}}));

}  // namespace
}  // namespace rubicon
