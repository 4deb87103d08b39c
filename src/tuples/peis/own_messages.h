#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "base/bytes.h"
#include "rubicon/address.hpp"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"
#include "rubicon/tuple.hpp"
#include "tuples/link.h"
#include "tuples/peis/tuple_wire.h"
#include "tuples/peis/wire.h"

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

// What components of ours add to a tuple that goes to another one of ours: kAnnexMark, then big-endian fields.
// Durations are whole microseconds up to kMaxAnnexDuration; longer ones are cut, fractions rounded down.

inline constexpr Duration kMaxAnnexDuration = std::chrono::microseconds((std::int64_t{1} << 47) - 1);  ///< 4.4 years

/// In SUBSCRIBE and UNSUBSCRIBE: id u32, passive 1 bit, minimum 47 bit, maximum 48 bit, dead band IEEE 754 64 bit.
struct SubscribeAnnex {
  std::uint32_t id = 0;  ///< unique per subscriber, not 0
  Flow flow;
  friend bool operator==(const SubscribeAnnex&, const SubscribeAnnex&) = default;
};
Annex to_annex(const SubscribeAnnex& fields);
/// nullopt: not of ours, or an id of 0, a maximum above kMaxAnnexDuration, a dead band that is negative or not finite.
std::optional<SubscribeAnnex> read_subscribe_annex(const Annex& annex);

/// In SET_REMOTE: request u64, flags u16 (1 time to live, 2 sequence expected, 4 the sender gave the time to live, 8
/// append, 16 no media type), time to live 48 bit, sequence u64.
struct SetAnnex {
  std::uint64_t request = 0;               ///< unique per writer, not 0
  std::optional<Duration> time_to_live{};  ///< what remains of it; empty = no limit
  std::optional<std::uint64_t> expected_sequence{};
  bool time_to_live_given = false;  ///< by the sender; if not, it is a default
  bool append = false;              ///< to the present value
  bool no_media_type = false;       ///< the one in the message stands for an empty one
  friend bool operator==(const SetAnnex&, const SetAnnex&) = default;
};
Annex to_annex(const SetAnnex& fields);
/// nullopt: not of ours, or a request of 0, unknown flags, a time to live above kMaxAnnexDuration.
std::optional<SetAnnex> read_set_annex(const Annex& annex);
/// Changes the time to live in a SET_REMOTE that has one.
void put_time_to_live(std::span<std::uint8_t> set_remote, Duration remaining);

/// In PUSH_TUPLE: flags u16 (1 deleted, 2 expired, 4 no media type), 2 zero bytes, sequence u64.
struct PushAnnex {
  std::uint64_t sequence = 0;
  EventKind kind = EventKind::kSet;  ///< kSet, kDeleted or kExpired
  bool no_media_type = false;        ///< the one in the message stands for an empty one
  friend bool operator==(const PushAnnex&, const PushAnnex&) = default;
};
Annex to_annex(const PushAnnex& fields);
/// nullopt: not of ours, unknown flags, deleted and expired at once.
std::optional<PushAnnex> read_push_annex(const Annex& annex);

// Messages between components of ours, on ports that kernels ignore: big-endian, in front the mark `RBC1`.

/// Port 41: request u64, sequence u64, verdict u8, error code u8, then the text.
Bytes write_reply(const Reply& reply);
/// kInvalid: too short, another mark, an unknown verdict or error code. The receiver is not in it.
Result<Reply> read_reply(ByteView body);

/// Port 43: kind u8 (1 end of a snapshot, 2 restart, 3 forget), 3 zero bytes, then subscription u32, or since u64
/// (microseconds), or nothing.
Bytes write_control(const SnapshotEnd& end);
Bytes write_control(const Restart& restart);
/// All subscriptions of the sender end; those that it has follow.
Bytes write_forget();
bool is_forget(ByteView body);
/// A SnapshotEnd or a Restart.
Result<Change> read_control(ByteView body);

}  // namespace rubicon::tuples::peis
