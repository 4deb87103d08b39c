#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "rubicon/time.hpp"

namespace rubicon::tuples::dds {

/// What became of the interfaces that DDS uses, since the start.
struct InterfaceNews {
  struct State {
    std::string address;  ///< IPv4; empty = none
    std::string lack;     ///< why it reaches no other host: `has no IPv4 address`; empty = nothing
    friend bool operator==(const State&, const State&) = default;
  };
  std::map<std::string, State> interfaces;  ///< by name; empty until they were looked at
  std::uint64_t changes = 0;                ///< how often the components entered with other addresses
  WallTime changed{};                       ///< the last time
};

}  // namespace rubicon::tuples::dds
