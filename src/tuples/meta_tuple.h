#pragma once

#include <string>
#include <string_view>

#include "rubicon/tuple_space.hpp"

namespace rubicon::tuples {

// A meta tuple is an ordinary tuple whose value names another one, which may be a meta tuple too. Everything here sees
// what TupleSpace::get sees: own tuples, and of foreign ones those that a subscription covers.

/// Which tuple: its owner and its key, no wildcards. Text form `6541:proxy.wsn-1.7.sensor.light-1.value`.
struct TupleName {
  OwnerId owner{};
  std::string key;

  friend bool operator==(const TupleName&, const TupleName&) = default;
};
std::string to_string(const TupleName& name);

/// What makes a tuple a meta tuple: its media type. The value is the text form of a TupleName; empty = names nothing.
inline constexpr std::string_view kReferenceMediaType = "application/rubicon-reference";
/// The spelling of the PEIS kernel, read but never written: `(META 6541 proxy.x)`, perhaps with a NUL behind it; owner
/// -1 with key NULL names nothing (PEIS kernel G6: meta tuples).
inline constexpr std::string_view kPeisReferenceMediaType = "x-peis/metatuple";

/// References in a row that are followed.
inline constexpr std::size_t kMaxReferences = 8;

bool is_reference(std::string_view media_type);

/// kNotFound when it names nothing, kInvalid when it is no reference or names no possible tuple.
Result<TupleName> read_reference(std::string_view media_type, std::string_view value);

/// Makes an own tuple a meta tuple, or one that names another target. kRefused (with the names) if that would close a
/// cycle, kOutOfRange if more than kMaxReferences would follow each other, as far as can be seen here; kInvalid for
/// impossible names.
Result<void> set_reference(TupleSpace& space, std::string_view key, const TupleName& target);
/// The same with the meta tuple of another component, by a remote set; returns its request number.
Result<std::uint64_t> set_reference(TupleSpace& space, const TupleName& meta, const TupleName& target,
                                    Duration time_to_live, ReplyCall call);

/// The tuple at the end of the references. It need not be there: a name that is not seen to be a meta tuple is an end.
/// kNotFound: `meta` is not there, or a reference names nothing; kInvalid: no meta tuple, or a reference that cannot be
/// read; kRefused: a cycle, with its names; kOutOfRange: more than kMaxReferences.
Result<TupleName> resolve(const TupleSpace& space, const TupleName& meta);

/// The tuple at the end. kNotFound if it is not there or not covered by a subscription, else as resolve.
Result<TupleView> get_through(const TupleSpace& space, const TupleName& meta);

/// A remote set (append) to the tuple at the end, as it is known now, under the rules of TupleSpace::set_remote; an own
/// target goes through one's own judge too. Errors as get_through: the target must be seen here, or it would stay
/// unknown whether it refers on, and a reference might be overwritten. A passive subscription is enough.
Result<std::uint64_t> set_through(TupleSpace& space, const TupleName& meta, std::string_view value,
                                  Duration time_to_live, ReplyCall call, const SetOptions& options = {});
Result<std::uint64_t> append_through(TupleSpace& space, const TupleName& meta, std::string_view bytes,
                                     Duration time_to_live, ReplyCall call, const SetOptions& options = {});

/// The tuple at the end, or why there is none (as resolve says it).
using TargetCall = std::function<void(const Result<TupleName>& target)>;

/// Follows `meta`: subscribes passively to it and every further meta tuple, with `flow` to the tuple at the end, whose
/// events are passed on under its own name. When a reference changes, the old target's subscription (and demand) ends
/// and the new one's begins; the present value of the new one is told, the change itself only to `target_call`. When a
/// meta tuple or the target goes, and when the references lead nowhere, the value told last is told as deleted, once;
/// all is taken up again when they lead somewhere. Calls come in later turns; each may end the Handle. Bounded: at most
/// kMaxReferences + 1 subscriptions. A key that is not well formed gives an empty Handle, as with subscribe.
[[nodiscard]] Handle subscribe_through(TupleSpace& space, const TupleName& meta, const Flow& flow, EventCall call,
                                       TargetCall target_call = {});

}  // namespace rubicon::tuples
