#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace rubicon::networks::knx::wire {

/// Status codes that the state machines handle (KNX 3/8/2, 7.8; 3/8/4).
namespace status {
constexpr std::uint8_t kOk = 0x00, kUnknownConnection = 0x21, kConnectionType = 0x22, kNoMoreConnections = 0x24,
                       kNoUniqueConnection = 0x25, kBusDown = 0x27, kUnauthorised = 0x28, kLayer = 0x29,
                       kAddressInUse = 0x2e;
}  // namespace status

/// What a client does about a status.
enum class Remedy : std::uint8_t {
  kNone,           ///< not an error
  kReconnect,      ///< connect again at once: the server has forgotten the connection
  kRetry,          ///< connect again after a growing pause
  kWaitForSlot,    ///< another client has the tunnel or address: report it, retry after a growing pause
  kConfiguration,  ///< only a change of configuration helps: report it, retry rarely
  kBusDown,        ///< the connection works, the bus does not: keep the connection
};

struct StatusMeaning {
  std::string_view meaning;  ///< text for the user
  Remedy remedy = Remedy::kRetry;
};

/// The meaning of a status in a response of the server. The remedy of unknown codes is kRetry.
StatusMeaning meaning_of(std::uint8_t status);
/// `all tunnels of the interface are in use (status 24)`.
std::string describe_status(std::uint8_t status);

}  // namespace rubicon::networks::knx::wire
