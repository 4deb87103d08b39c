#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "rubicon/result.hpp"

namespace rubicon::networks::knx::wire {

/// Destination of group telegrams; 0 is the broadcast address (KNX 3/3/3).
enum class GroupAddress : std::uint16_t {};
/// A device on the bus: area 4 bit, line 4 bit, device 8 bit; 0 = not set (KNX 3/3/2).
enum class IndividualAddress : std::uint16_t {};

/// How a project writes its group addresses; on the wire they are numbers.
enum class Notation : std::uint8_t { kThreeLevel, kTwoLevel, kFree };

/// `1/2/7`, `1/519`, `2567`. kInvalid for anything else, kOutOfRange names the part; 0/0/0 is refused.
Result<GroupAddress> parse_group(std::string_view text);
std::string to_string(GroupAddress address, Notation notation = Notation::kThreeLevel);
/// As part of a key: `1_2_7`.
std::string to_key_part(GroupAddress address);

/// `1.1.200`; 0.0.0 is allowed.
Result<IndividualAddress> parse_individual(std::string_view text);
std::string to_string(IndividualAddress address);

constexpr std::uint16_t number(GroupAddress address) {
  return static_cast<std::uint16_t>(address);
}
constexpr std::uint16_t number(IndividualAddress address) {
  return static_cast<std::uint16_t>(address);
}

}  // namespace rubicon::networks::knx::wire
