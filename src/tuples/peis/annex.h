#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "rubicon/tuple.hpp"
#include "tuples/peis/tuple_wire.h"

namespace rubicon::tuples::peis {

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

}  // namespace rubicon::tuples::peis
