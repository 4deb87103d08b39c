#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "base/bytes.h"
#include "rubicon/address.hpp"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::tuples::peis {

// Tuples on the wire of G6: peis.md, section 3.8, as corrected in section 6. Views refer to the bytes that they were
// read from. Fields that a prototype leaves open (-1 on the wire) are empty optionals.

/// Decides how append joins two values: ASCII replaces the trailing NUL of the value before.
enum class Encoding : std::uint8_t { kAscii = 0, kBinary = 1 };

inline constexpr std::size_t kNetworkTupleSize = 224;
inline constexpr std::size_t kMaxPeisKey = 127;    ///< bytes
inline constexpr std::size_t kMaxMediaType = 254;  ///< bytes; 255 on the wire is read as none
/// With these expire seconds a set deletes the tuple (peis.md, section 1.4).
inline constexpr WallTime kDeleteTime{std::chrono::seconds(1)};

/// The 28 bytes at 48 that kernels ignore and fill with old memory. Components of ours write kAnnexMark and fields of
/// their own (own_messages.h); heed it only from those.
using Annex = std::array<std::uint8_t, 28>;
inline constexpr std::array<std::uint8_t, 4> kAnnexMark{'R', 'B', 'C', '1'};

/// A tuple, or the prototype of tuples. The default is the prototype of all tuples.
///
/// Times are whole microseconds; zero = not given, never. Written times are limited to 1970 to 2038, what seconds in
/// 32 bits can say.
struct NetworkTuple {
  std::optional<OwnerId> owner;  ///< empty = any
  std::string_view key;          ///< at most kMaxPeisKey bytes, no NUL; `*` = any part, empty = any key
  std::optional<OwnerId> creator;
  std::optional<WallTime> write_time, user_time, expire_time;
  std::optional<Encoding> encoding;
  std::string_view media_type;           ///< at most kMaxMediaType bytes; empty = any
  std::optional<std::string_view> data;  ///< text with its trailing NUL
  std::optional<std::uint32_t> sequence;
  std::uint32_t appends = 0;  ///< since the last set; kernels begin at any number (section 6.1, 5)
  Annex annex{};              ///< all zero without kAnnexMark
  friend bool operator==(const NetworkTuple&, const NetworkTuple&) = default;
};

/// kInvalid: a kernel would drop it or read memory that is not set, because a field is open that a tuple must have
/// (section 6.2, 9): owner, key without wildcard, creator, user and expire time, encoding, media type, at least one
/// byte of data. The text names the field.
Result<void> check_concrete(const NetworkTuple& tuple);

/// PUSH_TUPLE, from the owner to a subscriber. Concrete, with write time and sequence.
Result<NetworkTuple> read_push(ByteView body);
Bytes write_push(const NetworkTuple& tuple);
/// The same in the place of what `out` holds.
void write_push_into(const NetworkTuple& tuple, Bytes& out);

/// SET_REMOTE, from a writer to the owner. Concrete. Kernels take over a sequence other than 0: always write 0
/// (section 6.1, 9).
Result<NetworkTuple> read_set_remote(ByteView body);
Bytes write_set_remote(const NetworkTuple& tuple);

/// SUBSCRIBE: a prototype. Set owner, key, media type and data only: kernels that see a write time never push (section
/// 6.1, 4).
struct Subscribe {
  bool force_resend = true;  ///< false: one of all subscriptions of a host that was just met
  NetworkTuple prototype;
  friend bool operator==(const Subscribe&, const Subscribe&) = default;
};
Result<Subscribe> read_subscribe(ByteView body);
Bytes write(const Subscribe& subscribe);

/// UNSUBSCRIBE: all that can be trusted of it (section 6.3, 21); the media type of the subscription is not in it.
struct Unsubscribe {
  std::optional<OwnerId> owner;
  std::string_view key;
  std::optional<std::string_view> data;
  Annex annex{};
  friend bool operator==(const Unsubscribe&, const Unsubscribe&) = default;
};
Result<Unsubscribe> read_unsubscribe(ByteView body);
Bytes write(const Unsubscribe& unsubscribe);

/// SET_APPEND: appends to the tuples of the owner that match a prototype. The media type is not in it.
struct SetAppend {
  NetworkTuple prototype;
  std::string_view difference;
  friend bool operator==(const SetAppend&, const SetAppend&) = default;
};
Result<SetAppend> read_set_append(ByteView body);
Bytes write(const SetAppend& append);

/// PUSH_APPENDED: the tuple as it was before, without its data and media type, and what was appended. A key with
/// wildcards stands for all tuples that match (section 6.2, 11).
struct PushAppended {
  NetworkTuple tuple;
  std::uint8_t media_type_length = 0;
  std::uint32_t data_length = 0;
  std::string_view difference;
  friend bool operator==(const PushAppended&, const PushAppended&) = default;
};
Result<PushAppended> read_push_appended(ByteView body);
Bytes write(const PushAppended& appended);

}  // namespace rubicon::tuples::peis
