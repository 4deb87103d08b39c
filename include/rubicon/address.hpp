#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <string>

namespace rubicon::model {

/// A component of the tuple space (D1.4: peis-id). Islands take 1..65532 (motes carry 16 bits), others ids above 65535.
enum class OwnerId : std::uint32_t {};

/// An island is a component: its proxy's id is the island's id (D1.4, Architecture).
using IslandId = OwnerId;

inline constexpr OwnerId kNoOwner{0};
inline constexpr std::uint32_t kMaxIslandId = 65532;

constexpr std::uint32_t number(OwnerId id) {
  return static_cast<std::uint32_t>(id);
}
constexpr bool is_island(OwnerId id) {
  return number(id) >= 1 && number(id) <= kMaxIslandId;
}

/// Where a message comes from or goes to. Empty device = the network itself; empty network = the island's gateway.
/// The device is spelled as its network spells it (`1.4.6`, `7`), not as in a key.
struct Address {
  IslandId island = kNoOwner;
  std::string network;
  std::string device;

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
