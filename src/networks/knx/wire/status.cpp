#include "networks/knx/wire/status.h"

#include <fmt/format.h>

namespace rubicon::networks::knx::wire {

StatusMeaning meaning_of(std::uint8_t status) {
  switch (status) {
    case status::kOk: return {"ok", Remedy::kNone};
    case 0x01: return {"the interface does not support this transport protocol", Remedy::kConfiguration};
    case 0x02: return {"the interface does not support this KNXnet/IP version", Remedy::kConfiguration};
    case 0x04: return {"a sequence number was out of order", Remedy::kRetry};
    case 0x0f: return {"the interface reports an unspecified error", Remedy::kRetry};
    case status::kUnknownConnection: return {"the interface does not know the connection", Remedy::kReconnect};
    case status::kConnectionType:
      return {"the interface does not offer this type of connection (does it require KNX IP Secure?)",
              Remedy::kConfiguration};
    case 0x23: return {"the interface does not support an option of the connection", Remedy::kConfiguration};
    case status::kNoMoreConnections: return {"all tunnels of the interface are in use", Remedy::kWaitForSlot};
    case status::kNoUniqueConnection:
      return {"a tunnel is free, but its individual address is in use", Remedy::kWaitForSlot};
    case 0x26: return {"the interface reports an error of the data connection", Remedy::kReconnect};
    case status::kBusDown: return {"the interface has no connection to the KNX bus", Remedy::kBusDown};
    case status::kUnauthorised: return {"the interface does not authorise this user", Remedy::kConfiguration};
    case status::kLayer: return {"the interface does not support this tunnelling layer", Remedy::kConfiguration};
    case 0x2d: return {"the interface has no tunnel with the requested individual address", Remedy::kConfiguration};
    case status::kAddressInUse: return {"the requested tunnel address is in use", Remedy::kWaitForSlot};
    default: return {"unknown status", Remedy::kRetry};
  }
}

std::string describe_status(std::uint8_t status) {
  return fmt::format("{} (status {:02X})", meaning_of(status).meaning, status);
}

}  // namespace rubicon::networks::knx::wire
