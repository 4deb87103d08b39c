#include <cstdlib>

#include "fuzz_target.h"
#include "networks/zigbee/bridge/device_record.h"
#include "networks/zigbee/bridge/messages.h"

namespace rubicon::fuzz::zigbee_event_fuzz {

/// Input: a payload of bridge/event. A known event names a device.
FUZZ_TARGET(zigbee_event) {
  using namespace rubicon::networks::zigbee::bridge;
  const auto event = read_event({reinterpret_cast<const char*>(data), size});
  if (!event) {
    if (event.error().text.empty()) std::abort();
    return 0;
  }
  const bool known = event->kind != BridgeEvent::Kind::kOther;
  if (known && address_of(ieee_of(event->address)) != event->address) std::abort();
  if (known && event->address.size() != 16) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::zigbee_event_fuzz
