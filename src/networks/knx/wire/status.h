#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace rubicon::networks::knx::wire {

/// Status codes with a meaning of their own in the state machines (KNX 3/8/2, 7.8; 3/8/4).
namespace status {
constexpr std::uint8_t kOk = 0x00, kUnknownConnection = 0x21, kConnectionType = 0x22, kNoMoreConnections = 0x24,
                       kNoUniqueConnection = 0x25, kBusDown = 0x27, kLayer = 0x29, kAddressInUse = 0x2e;
}  // namespace status

/// What a client does about a status.
enum class Remedy : std::uint8_t {
  kNone,           ///< all is well
  kReconnect,      ///< at once: the server forgot us
  kRetry,          ///< with the usual growing pause
  kWaitForSlot,    ///< somebody else has what we want: wait, with a growing pause, and say so
  kConfiguration,  ///< will not get better by itself: say so, try again seldom
  kBusDown,        ///< the link is good, the bus behind it is not: go on
};

struct StatusMeaning {
  std::string_view meaning;  ///< in words, for the user
  Remedy remedy = Remedy::kRetry;
};

/// Meaning of a status in an answer of the server; unknown codes are retried.
StatusMeaning meaning_of(std::uint8_t status);
/// `all tunnels of the interface are in use (status 24)`.
std::string describe_status(std::uint8_t status);

}  // namespace rubicon::networks::knx::wire
