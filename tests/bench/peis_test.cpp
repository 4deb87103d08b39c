#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <ostream>
#include <string>
#include <vector>

#include "support/process.h"

namespace rubicon {
namespace {

using nlohmann::json;

struct Measurement {
  std::string name;
  std::vector<std::string> figures;  ///< what it measures
  std::vector<std::string> faults;   ///< what must be 0 however busy the machine is
};

std::ostream& operator<<(std::ostream& out, const Measurement& measurement) {
  return out << measurement.name;
}

class BenchOfPeis : public testing::TestWithParam<Measurement> {};

TEST_P(BenchOfPeis, ShortRunMeasuresAllAndLosesNothing) {
  const auto run = support::run_to_end(
      {RUBICON_BINARY_DIR "/bin/rubicon-bench-peis", "--quick", "--json", "--only", GetParam().name});
  ASSERT_EQ(run.code, 0) << run.errors;
  const auto out = json::parse(run.output);
  for (const auto& figure : GetParam().figures)
    EXPECT_TRUE(out.contains(figure) && !out.at(figure).is_null()) << figure;
  for (const auto& fault : GetParam().faults) EXPECT_EQ(out.value(fault, -1), 0) << fault;
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
