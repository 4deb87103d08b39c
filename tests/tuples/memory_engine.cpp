#include "tuples/memory/memory_ecology.h"
#include "tuples/test_ecology.h"

namespace rubicon::tuples {

const bool kMeetAtOnce = true;
const bool kOneIdMayStartTwice = false;

std::unique_ptr<TestEngine> make_test_engine(VirtualScheduler& time) {
  return std::make_unique<TestEngineOf<MemoryEcology>>(time);
}

}  // namespace rubicon::tuples
