#include "bench/short_run.h"

namespace rubicon {
namespace {

class BenchOfRos2 : public testing::TestWithParam<Measurement> {};

TEST_P(BenchOfRos2, ShortRunMeasuresAll) {
  short_run("rubicon-bench-ros2", GetParam(), {});
}

INSTANTIATE_TEST_SUITE_P(All, BenchOfRos2,
                         testing::Values(Measurement{"topics", {"visible_s", "topic_kb", "bare_topic_kb"}, {}},
                                         Measurement{"latency", {"p50_ratio", "p99_ratio"}, {}},
                                         Measurement{"flood", {"flood_per_s", "flood_lost"}, {}},
                                         Measurement{"idle", {"idle_percent"}, {"idle_awake"}}));

}  // namespace
}  // namespace rubicon
