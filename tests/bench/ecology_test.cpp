#include "bench/short_run.h"

namespace rubicon {
namespace {

class BenchOfEcology : public testing::TestWithParam<std::string> {
 protected:
  void measure(const Measurement& measurement) const {
    short_run("rubicon-bench-ecology", measurement, {"--json", "--engine", GetParam()});
  }
};

TEST_P(BenchOfEcology, EachCommandOfEightProgramsEndsOnceAndAsTheLampSawIt) {
  measure({"lamp", {"lamp_seen", "lamp_confirmed"}, {"lamp_faults"}});
}

TEST_P(BenchOfEcology, ACrowdMeets) {
  measure({"crowd", {"all_see_all_s", "idle_cpu_percent", "crowd_private_mb", "crowd_lost"}, {}});
}

TEST_P(BenchOfEcology, OneOfThemIsStoppedAndGoesOn) {
  // DDS counts silence: a lease passes on a busy machine too. On a host the kernel tells who has ended.
  const std::vector<std::string> faults{"stops_lost"};
  measure({"stops", {"stops_lost"}, GetParam() == "host" ? faults : std::vector<std::string>{}});
}

INSTANTIATE_TEST_SUITE_P(Both, BenchOfEcology, testing::Values("host", "dds"));

}  // namespace
}  // namespace rubicon
