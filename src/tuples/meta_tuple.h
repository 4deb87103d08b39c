#pragma once

#include <string>
#include <string_view>

#include "rubicon/tuple_space.hpp"

namespace rubicon::tuples {

// A meta tuple is an ordinary tuple whose value names another one, which may be a meta tuple too. These functions use
// what TupleSpace::get() knows: own tuples, and copies that a subscription covers.

/// Names one tuple: its owner and its key, without wildcards. Text form `6541:proxy.wsn-1.7.sensor.light-1.value`.
struct TupleName {
  OwnerId owner{};
  std::string key;

  friend bool operator==(const TupleName&, const TupleName&) = default;
};
std::string to_string(const TupleName& name);

/// The media type of meta tuples. The value is the text form of a TupleName; empty = names nothing.
inline constexpr std::string_view kReferenceMediaType = "application/rubicon-reference";
/// The form of the PEIS kernel, read but never written: `(META 6541 proxy.x)`, possibly followed by a NUL; owner -1
/// with key NULL names nothing (PEIS kernel G6: meta tuples).
inline constexpr std::string_view kPeisReferenceMediaType = "x-peis/metatuple";

/// Maximum length of a chain of references.
inline constexpr std::size_t kMaxReferences = 8;

bool is_reference(std::string_view media_type);

/// kNotFound if the reference names nothing, kInvalid if it is not a reference or names no valid tuple.
Result<TupleName> read_reference(std::string_view media_type, std::string_view value);

/// Makes an own tuple a meta tuple, or changes its target. Checks what is known here. kRefused (with the names): it
/// would close a cycle. kOutOfRange: the chain would exceed kMaxReferences. kInvalid for invalid names.
Result<void> set_reference(TupleSpace& space, std::string_view key, const TupleName& target);
/// The same with the meta tuple of another component, by a remote set; returns its request number.
Result<std::uint64_t> set_reference(TupleSpace& space, const TupleName& meta, const TupleName& target,
                                    Duration time_to_live, ReplyCall call);

/// The target: the tuple at the end of the references. It need not exist: a tuple that is not known to be a meta tuple
/// is a target. kNotFound: `meta` does not exist, or a reference names nothing; kInvalid: no meta tuple, or a malformed
/// reference; kRefused: a cycle, with its names; kOutOfRange: more than kMaxReferences.
Result<TupleName> resolve(const TupleSpace& space, const TupleName& meta);

/// The value of the target. kNotFound if it does not exist or is not covered by a subscription, else as resolve().
Result<TupleView> get_through(const TupleSpace& space, const TupleName& meta);

/// Sends a remote set (append) to the present target under the rules of TupleSpace::set_remote(); own targets are
/// subject to their policy too. Errors as get_through(): the target must be known here, because otherwise it could be
/// another meta tuple, whose reference would be overwritten. A passive subscription is enough.
Result<std::uint64_t> set_through(TupleSpace& space, const TupleName& meta, std::string_view value,
                                  Duration time_to_live, ReplyCall call, const SetOptions& options = {});
Result<std::uint64_t> append_through(TupleSpace& space, const TupleName& meta, std::string_view bytes,
                                     Duration time_to_live, ReplyCall call, const SetOptions& options = {});

/// The target, or the error of resolve().
using TargetCall = std::function<void(const Result<TupleName>& target)>;

/// Follows `meta`: subscribes passively to it and to each further meta tuple, and with `flow` to the target, whose
/// events are delivered under its own name. When a reference changes, the subscription (and demand) moves to the new
/// target: its present value is delivered to `call`, the change itself to `target_call`. When a meta tuple or the
/// target is removed, or the references have no target any longer, the last delivered value is reported as deleted,
/// once; delivery resumes when there is a target again. Calls come in later turns; each may end the Handle. At most
/// kMaxReferences + 1 subscriptions. An invalid key gives an empty Handle, as with subscribe().
[[nodiscard]] Handle subscribe_through(TupleSpace& space, const TupleName& meta, const Flow& flow, EventCall call,
                                       TargetCall target_call = {});

}  // namespace rubicon::tuples
