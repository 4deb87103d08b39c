#pragma once

#include <cstdint>
#include <string_view>
#include <variant>

#include "rubicon/tuple.hpp"

namespace rubicon::tuples {

/// The owner set a tuple; `tuple.owner` is the sender.
struct TupleSet {
  TupleView tuple;
};

/// A tuple was deleted or expired.
struct TupleGone {
  EventKind how = EventKind::kDeleted;  ///< kDeleted or kExpired
  std::string_view key;
  std::uint64_t sequence = 0;
};

/// All tuples that the subscription covers have been sent. Copies that were not among them no longer exist.
struct SnapshotEnd {
  std::uint32_t subscription = 0;  ///< SubscriptionSpec::id
};

/// The sender had lost this subscriber: what follows replaces what was sent before, whatever its sequence.
struct Restart {
  /// When that began, by the clock of the sender; later than in each Restart before. Orders the streams of one sender
  /// that arrive over several engines. Zero = not given.
  WallTime since{};
};

/// What an owner sends to a subscriber, in order. The views are valid during the call that passes it.
using Change = std::variant<TupleSet, TupleGone, SnapshotEnd, Restart>;

/// Bytes of the texts in it.
inline std::size_t text_size(const Change& change) {
  if (const auto* set = std::get_if<TupleSet>(&change))
    return set->tuple.key.size() + set->tuple.value.size() + set->tuple.media_type.size();
  const auto* gone = std::get_if<TupleGone>(&change);
  return gone ? gone->key.size() : 0;
}

}  // namespace rubicon::tuples
