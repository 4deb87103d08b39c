#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <string>

namespace rubicon::model {

/// Identifies a component of the tuple space (D1.4: peis-id). Islands have ids 1..65532, because motes carry 16 bits;
/// all other components have ids above 65535.
enum class OwnerId : std::uint32_t {};

/// The owner id of an island's proxy, which identifies the island too (D1.4, Architecture).
using IslandId = OwnerId;

inline constexpr OwnerId kNoOwner{0};  ///< no component has this id
inline constexpr std::uint32_t kMaxIslandId = 65532;

constexpr std::uint32_t number(OwnerId id) {
  return static_cast<std::uint32_t>(id);
}
constexpr bool is_island(OwnerId id) {
  return number(id) >= 1 && number(id) <= kMaxIslandId;
}

/// The source or the destination of a message.
struct Address {
  IslandId island = kNoOwner;
  std::string network;  ///< id of the network, `knx-hall`; empty = the island's gateway
  std::string device;   ///< in the notation of its network (`1.4.6`, `7`), not as in a key; empty = the network itself

  friend bool operator==(const Address&, const Address&) = default;
  friend auto operator<=>(const Address&, const Address&) = default;
};

/// `6541/wsn-1/7`, for logs and error texts.
std::string to_string(const Address& address);

}  // namespace rubicon::model

namespace rubicon {
using model::Address;
using model::IslandId;
using model::OwnerId;
}  // namespace rubicon
