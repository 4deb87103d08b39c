#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/bytes.h"
#include "rubicon/address.hpp"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::tuples::peis {

/// What a component of ours says to another one, on port 40, which G6 ignores. 4 bytes `RBC1`, version u16, lease in
/// milliseconds u32, incarnation u64, big-endian, then the host id as text.
struct Hello {
  static constexpr std::uint16_t kVersion = 1;
  static constexpr std::size_t kMaxHostId = 64;

  std::uint16_t version = kVersion;
  Duration lease = std::chrono::seconds(2);  ///< 500 ms to 60 s: silent for longer, it counts as lost
  std::uint64_t incarnation = 0;             ///< time of the start, microseconds since 1970
  std::string host_id;                       ///< differs between hosts, at most 64 bytes

  friend bool operator==(const Hello&, const Hello&) = default;
};

Bytes encode(const Hello& hello);
/// kInvalid if it is none. Later versions may append: what follows is part of the host id up to a NUL.
Result<Hello> decode_hello(ByteView body);

/// Who a host is.
struct Identity {
  OwnerId id{};
  std::uint32_t magic = 0;  ///< of its start
  std::string host_name;
  std::string full_name;       ///< `name@host!pid`
  std::optional<Hello> hello;  ///< only components of ours have one

  friend bool operator==(const Identity&, const Identity&) = default;
};

/// A summary for a host that publishes none: the name and the host of a kernel, as it announces them.
std::string kernel_summary(const Identity& host);

}  // namespace rubicon::tuples::peis
