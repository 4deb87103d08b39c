#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.h"
#include "model/value.h"

namespace rubicon::networks::salad {

/// A device's number in SALAD, 1..65535 (salad.md, section 5).
using DeviceId = std::uint16_t;

/// One reading of a datagram. Whole numbers are int64, or their digits as text if they do not fit; others are double.
struct Item {
  DeviceId id = 0;
  Value value;

  friend bool operator==(const Item&, const Item&) = default;
};

/// Why a datagram or an item of it was dropped (salad.md, section 4, line by line).
enum class Fault : std::uint8_t {
  kNotSalad,  ///< does not begin with `#SALADST#`
  kEmpty,     ///< no item in it
  kForm,      ///< an item does not have exactly one `;`
  kId,        ///< the id is not a decimal number from 1 to 65535
  kValue,     ///< the value is not a plain decimal number, or too large for one
  kCut,       ///< the last item of a datagram that fills the buffer
};
inline constexpr std::size_t kFaults = 6;
/// The fault as a counter's name: `dropped-bad-id`.
std::string_view to_string(Fault fault);

struct Datagram {
  std::vector<Item> items;                ///< in order; an id may appear twice
  std::map<Fault, std::uint64_t> faults;  ///< how often each occurred
};

/// SALAD -> proxy: `#SALADST#` id `;` value *( `:` id `;` value ) [ `#` anything ], again from each later `#SALADST#`
/// on (salad.md, sections 3 and 4). `buffer` is the size of the receive buffer in bytes: a datagram that fills it loses
/// its last item, which may be cut. Never fails: faults are counted.
Datagram read_datagram(ByteView bytes, std::size_t buffer);

/// A plain decimal number with optional sign, fraction and exponent. Whole numbers become int64 or, written without
/// fraction and exponent but too large for it, text; others double. nullopt for everything else: `0x1`, `1f`, `NaN`,
/// `1e400`.
std::optional<Value> read_number(std::string_view text);

/// Decimal digits with a value of 1..65535; nullopt for everything else.
std::optional<DeviceId> read_id(std::string_view text);

// Proxy -> SALAD (salad.md, section 2): `#SALAD#` op `:` arg `:` value `:0#END#`.
inline constexpr std::string_view kStartUpdates = "#SALAD#0:1:2:0#END#";
inline constexpr std::string_view kStopUpdates = "#SALAD#0:0:2:0#END#";
std::string actuate(std::string_view actuator, std::int64_t value);

/// One of the three requests above, as SALAD reads it.
struct Request {
  enum class Kind : std::uint8_t { kStart, kStop, kActuate };
  Kind kind = Kind::kStart;
  std::string actuator;
  std::int64_t value = 0;
};
std::optional<Request> read_request(ByteView bytes);

/// A datagram of SALAD with these items, which ends in `#END#`.
std::string write_datagram(const std::vector<Item>& items);

}  // namespace rubicon::networks::salad
