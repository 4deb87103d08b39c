#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "rubicon/address.hpp"
#include "rubicon/key.hpp"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::tuples {

/// One tuple as a reader sees it. The views are valid during the call that hands it over.
struct TupleView {
  OwnerId owner{};
  std::string_view key;
  std::string_view value;
  std::string_view media_type;
  OwnerId creator{};           ///< who wrote it last; differs from the owner after a remote set
  std::uint64_t sequence = 0;  ///< +1 by the owner at each set, from 1
  WallTime write_time{};       ///< when the owner published
  WallTime user_time{};        ///< when the device measured; zero = not given
  WallTime expire_time{};      ///< zero = never
  bool owner_present = true;  ///< false: a copy whose owner left or was lost; it may be old. Only get() and list() know
};

enum class EventKind : std::uint8_t { kSet, kDeleted, kExpired, kLost };
std::string_view to_string(EventKind kind);

/// What happened to a tuple: set (equal values too), deleted by its owner, its expiry time came, or (lost) its owner
/// left or was lost and did not come back within kOwnerGrace. For the last three the view shows the last value.
struct Event {
  EventKind kind = EventKind::kSet;
  TupleView tuple;
};
using EventCall = std::function<void(const Event&)>;

/// How a component came or went.
enum class PeerEvent : std::uint8_t { kUp, kLeft, kLost };

/// Longest summary a component may give of itself, in bytes; longer ones are not taken.
inline constexpr std::size_t kMaxSummary = 16UL * 1024;

/// How often a subscriber wants to hear of a tuple. Deletion and expiry are always told at once.
struct Flow {
  Duration minimum{
      0};  ///< at most one event in this time, the latest value always delivered; also the wanted sampling period
  Duration maximum{0};   ///< the present value again when nothing came for this long; zero = no heartbeat
  double dead_band = 0;  ///< numeric values: changes smaller than this against the last delivered one are held back
  bool passive = false;  ///< sees what there is, creates no demand

  friend bool operator==(const Flow&, const Flow&) = default;
};

struct SetOptions {
  std::string_view media_type = "text/plain";
  WallTime user_time{};
  Duration lifetime{0};  ///< the tuple expires this long after the write; zero = never
  /// Only if the tuple has this sequence now, else kRefused; 0 = only if it is not there. Sequences of a tuple that was
  /// deleted and made again start anew.
  std::optional<std::uint64_t> expected_sequence{};
};

/// A wish to change somebody else's tuple (or one's own, through the same judge).
struct RemoteSet {
  OwnerId from{};
  OwnerId owner{};
  std::uint64_t request = 0;  ///< unique per `from`
  std::string key;
  std::string value;
  std::string media_type = "text/plain";
  WallTime user_time{};
  Duration lifetime{0};
  Duration time_to_live{0};         ///< from the sending on; what remains is handed on with it. Zero = none given
  bool time_to_live_given = false;  ///< by the caller; else the space put its default
  bool append = false;              ///< `value` goes behind the present one; an empty media type = that of the tuple
  std::optional<std::uint64_t> expected_sequence{};  ///< checked by the owner's space before its judge is asked
};

enum class Verdict : std::uint8_t { kApplied, kRefused, kExpired, kNoSuchOwner };
std::string_view to_string(Verdict verdict);

/// The owner's answer to a RemoteSet.
struct Reply {
  OwnerId to{};
  std::uint64_t request = 0;
  Verdict verdict = Verdict::kApplied;
  ErrorCode code = ErrorCode::kRefused;  ///< of a refusal
  std::string text;                      ///< why not
  /// Of the tuple after the decision, when something was stored or a sequence was expected (0 = no such tuple); else 0.
  std::uint64_t sequence = 0;
};
using ReplyCall = std::function<void(const Reply&)>;

/// What the owner decides about a RemoteSet: store it as the tuple's value, take note without storing, or refuse.
struct SetDecision {
  Verdict verdict = Verdict::kApplied;
  bool store = true;
  ErrorCode code = ErrorCode::kRefused;
  std::string text;

  static SetDecision applied() { return {}; }
  static SetDecision consumed() { return {Verdict::kApplied, false, {}, {}}; }
  static SetDecision refused(Error why) { return {Verdict::kRefused, false, why.code, std::move(why.text)}; }
};
using SetPolicy = std::function<SetDecision(const RemoteSet&)>;

/// What a judge understands. One that looks at whole values would take a piece for one: appends only reach those who
/// say that they know them (RemoteSet::append).
enum class PolicyScope : std::uint8_t { kSets, kSetsAndAppends };

}  // namespace rubicon::tuples

namespace rubicon {
using tuples::Event;
using tuples::EventKind;
using tuples::Flow;
using tuples::PeerEvent;
using tuples::Reply;
using tuples::SetOptions;
using tuples::TupleView;
using tuples::Verdict;
}  // namespace rubicon
