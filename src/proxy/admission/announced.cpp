#include "proxy/admission/announced.h"

#include <fmt/format.h>

#include "proxy/memory.h"
#include "rubicon/key.hpp"

namespace rubicon::proxy::admission {

Announced last_announcement(const Device& device) {
  Announced announced{announcement(device), device.heard_at, device.joined};
  announced.join.heard = device.status != DeviceStatus::kUnknown;
  return announced;
}

bool same_announcement(const model::Join& one, const model::Join& other) {
  return one.name == other.name && one.model == other.model && one.device_type == other.device_type &&
         one.capabilities == other.capabilities;
}

std::string key_of(const DeviceName& device) {
  return fmt::format("{}.{}", model::to_key_part(device.network), model::to_key_part(device.address));
}

}  // namespace rubicon::proxy::admission
