#include "tuples/mqtt/mqtt_test_ecology.h"
#include "tuples/test_ecology.h"

namespace rubicon::tuples {

const bool kMeetAtOnce = false;
const bool kOneIdMayStartTwice = true;

std::unique_ptr<TestEngine> make_test_engine(VirtualScheduler& time) {
  return std::make_unique<TestEngineOf<mqtt::MqttTestEcology>>(time);
}

}  // namespace rubicon::tuples
