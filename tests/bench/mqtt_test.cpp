#include "bench/short_run.h"

namespace rubicon {
namespace {

class BenchOfMqtt : public testing::TestWithParam<Measurement> {};

TEST_P(BenchOfMqtt, ShortRunMeasuresAllAndLosesNothing) {
  short_run("rubicon-bench-mqtt", GetParam(), {});
}

INSTANTIATE_TEST_SUITE_P(All, BenchOfMqtt,
                         testing::Values(Measurement{"announcement", {"announced_s", "announced_mb"}, {}},
                                         Measurement{"mirror", {"mirror_ratio", "mirrored"}, {"mirror_dropped"}},
                                         Measurement{"commands", {"command_p99_ms", "bare_p99_ms"}, {"commands_lost"}},
                                         Measurement{"restarts", {"right_after_restart_s"}, {}},
                                         Measurement{"idle", {"idle_percent"}, {}}));

}  // namespace
}  // namespace rubicon
