#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "rubicon/address.hpp"
#include "rubicon/key.hpp"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::tuples {

/// One tuple. The string views are valid during the call that passes it.
struct TupleView {
  OwnerId owner{};
  std::string_view key;
  std::string_view value;
  std::string_view media_type;
  OwnerId creator{};           ///< component that wrote the value; differs from the owner after a remote set
  std::uint64_t sequence = 0;  ///< starts at 1; the owner increments it with each set
  WallTime write_time{};       ///< when the owner wrote it
  WallTime user_time{};        ///< when the device measured it; zero = not given
  WallTime expire_time{};      ///< zero = never
  /// False: a copy whose owner left or was lost; the value may be out of date. Set by get() and list() only.
  bool owner_present = true;
};

enum class EventKind : std::uint8_t { kSet, kDeleted, kExpired, kLost };
std::string_view to_string(EventKind kind);

/// A change of a tuple: its owner set it (also to an equal value), its owner deleted it, it expired, or it is lost: its
/// owner left or was lost, and did not return within kOwnerGrace. The view of a tuple that is gone shows its last
/// value.
struct Event {
  EventKind kind = EventKind::kSet;
  TupleView tuple;
};
using EventCall = std::function<void(const Event&)>;

/// A component appeared, left in an orderly way, or was not heard for its lease.
enum class PeerEvent : std::uint8_t { kUp, kLeft, kLost };

/// How often a subscriber receives a tuple. Deletion and expiry are always delivered at once.
struct Flow {
  /// Minimum interval: at most one event in this time; the latest value is always delivered. Also the sampling period
  /// that the subscriber asks for.
  Duration minimum{0};
  /// Heartbeat: the present value is delivered again after this time without an event; zero = no heartbeat.
  Duration maximum{0};
  /// Numeric values that differ from the last delivered one by less than this are not delivered.
  double dead_band = 0;
  /// The subscription receives what others have sampled; it creates no demand.
  bool passive = false;

  friend bool operator==(const Flow&, const Flow&) = default;
};

/// Optional parts of a set or an append.
struct SetOptions {
  std::string_view media_type = "text/plain";
  WallTime user_time{};  ///< when the device measured the value; zero = not given
  Duration lifetime{0};  ///< the tuple expires this long after the write; zero = never
  /// The write is refused (kRefused) unless the tuple has this sequence; 0 = unless the tuple does not exist. Sequences
  /// start again at 1 when a tuple is deleted and created again.
  std::optional<std::uint64_t> expected_sequence{};
  std::string_view asker{};  ///< RemoteSet::asker
};

/// Longest RemoteSet::asker, in bytes.
inline constexpr std::size_t kMaxAsker = 200;

/// A request to write a tuple of another component (or, under the same policy, an own one).
struct RemoteSet {
  OwnerId from{};
  OwnerId owner{};
  std::uint64_t request = 0;  ///< unique per `from`
  std::string key;
  std::string value;
  std::string media_type = "text/plain";
  WallTime user_time{};
  Duration lifetime{0};
  Duration time_to_live{0};         ///< time that remains for the request; zero = not given
  bool time_to_live_given = false;  ///< by the sender; if not, the owner may use a default of its own
  bool append = false;              ///< append `value` to the present one; an empty media type = that of the tuple
  std::optional<std::uint64_t> expected_sequence{};  ///< checked by the owner's space before the policy is called
  /// Who asks, as `from` says, who hands it on: `user:ann`, `member:desk`, `token:tablet`; empty = its own. The
  /// owner believes it where its rights let `from` vouch for that name (docs/rights.md). Engine peis cannot say it.
  std::string asker{};
};

enum class Verdict : std::uint8_t {
  kApplied,
  kRefused,
  kExpired,  ///< its time to live ended before the owner had it: it was not executed
  kNoSuchOwner,
  kTimedOut,  ///< the owner did not answer in time: it is not known whether it was executed. Said by the asker's side
};
std::string_view to_string(Verdict verdict);

/// The owner's answer to a RemoteSet.
struct Reply {
  OwnerId to{};
  std::uint64_t request = 0;
  Verdict verdict = Verdict::kApplied;
  ErrorCode code = ErrorCode::kRefused;  ///< reason of a refusal
  std::string text;                      ///< reason of a refusal, for people; or what was left out of an applied set
  /// Sequence of the tuple after the decision, if a value was stored or a sequence was expected; 0 = no such tuple.
  std::uint64_t sequence = 0;
};
using ReplyCall = std::function<void(const Reply&)>;

/// The owner's decision about a RemoteSet: store the value (applied), accept it without storing (consumed), or refuse.
struct SetDecision {
  Verdict verdict = Verdict::kApplied;
  bool store = true;
  ErrorCode code = ErrorCode::kRefused;
  std::string text;
  /// The set that the request amounts to, where it came under another key; for the audit.
  std::shared_ptr<const RemoteSet> meant{};

  static SetDecision applied() { return {}; }
  static SetDecision consumed() { return {Verdict::kApplied, false, {}, {}, {}}; }
  static SetDecision refused(Error why) { return {Verdict::kRefused, false, why.code, std::move(why.text), {}}; }
};
using SetPolicy = std::function<SetDecision(const RemoteSet&)>;

/// What a policy accepts. Appends (RemoteSet::append) reach only policies that opt in; others would take a fragment for
/// a whole value.
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
