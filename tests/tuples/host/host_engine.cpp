#include "tuples/host/host_test_ecology.h"
#include "tuples/test_ecology.h"

namespace rubicon::tuples {

const bool kMeetAtOnce = false;
const bool kOneIdMayStartTwice = false;

std::unique_ptr<TestEngine> make_test_engine(VirtualScheduler& time) {
  return std::make_unique<TestEngineOf<host::HostTestEcology>>(time);
}

}  // namespace rubicon::tuples
