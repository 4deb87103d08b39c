#include <fmt/format.h>

#include "base/assert.h"
#include "tuples/space_impl.h"

namespace rubicon::tuples {

namespace {

/// Between two looks whether the owners of sets that wait were found.
constexpr Duration kSeekStep = std::chrono::milliseconds(5), kLongSeekStep = std::chrono::milliseconds(100);

SetOptions options_of(const RemoteSet& set) {
  return {set.media_type, set.user_time, set.lifetime, set.expected_sequence};
}

}  // namespace

std::uint64_t TupleSpace::Impl::start_request(RemoteSet&& set, ReplyCall call) {
  RUBICON_DEBUG_ASSERT(scheduler.on_loop_thread());
  set.from = self;
  const auto request = set.request = requests.next_number();
  if (requests.full()) {
    later([request, me = self, call = std::move(call)] {
      if (call) call({me, request, Verdict::kRefused, ErrorCode::kBusy, "too many remote sets wait for their replies"});
    });
    return request;
  }
  requests.open(request, set.owner, set.time_to_live, std::move(call));
  send(std::move(set));
  return request;
}

void TupleSpace::Impl::send(RemoteSet&& set) {
  if (set.owner == self) {
    later([this, set = std::move(set)] { answer_own(set); });
  } else if (sought.has(set.owner)) {
    hold(set);
  } else if (auto sent = link.remote_set(set); !sent) {
    const bool may_come = sent.error().code == ErrorCode::kNotFound && link.seeks(set.owner);
    may_come ? hold(set) : refuse(set, sent.error());
  }
}

void TupleSpace::Impl::refuse(const RemoteSet& set, const Error& why) {
  const auto verdict = why.code == ErrorCode::kNotFound ? Verdict::kNoSuchOwner : Verdict::kRefused;
  later([this, owner = set.owner, reply = Reply{self, set.request, verdict, why.code, why.text}] {
    requests.answer(owner, reply);
  });
}

/// Until the link has found the owner, or knows that it is not there.
void TupleSpace::Impl::hold(const RemoteSet& set) {
  if (!sought.hold(set, scheduler.now()))
    return refuse(set, {ErrorCode::kBusy, "too many remote sets wait for their owners"});
  requests.set_left(set.request, false);
  seek_step = kSeekStep;
  sought_due.advance_to(scheduler.now() + seek_step);
}

void TupleSpace::Impl::release_sought() {
  const auto alive = lifetime.watch();
  seek_step = std::min(2 * seek_step, kLongSeekStep);
  sought.drop_ended(scheduler.now());
  for (const auto owner : sought.owners()) {
    if (link.seeks(owner)) {
      sought_due.advance_to(scheduler.now() + seek_step);
      continue;
    }
    for (auto& set : sought.take(owner, scheduler.now())) {
      requests.set_left(set.request, true);
      send(std::move(set));
      if (alive.ended()) return;
    }
  }
}

Result<void> TupleSpace::Impl::check_sizes(const RemoteSet& set) {
  if (auto ok = model::check_key(set.key); !ok) return ok;
  if (set.value.size() <= kMaxValueSize) return {};
  return fail(ErrorCode::kOutOfRange, fmt::format("the value for {} has {} bytes, at most {} are allowed", set.key,
                                                  set.value.size(), kMaxValueSize));
}

/// The sizes of sets of others were checked when they came.
SetDecision TupleSpace::Impl::decide(const RemoteSet& set) {
  if (auto ok = set.from == self ? check_sizes(set) : Result<void>(); !ok) return SetDecision::refused(ok.error());
  const auto policy = policies.find(self, set.key);
  const auto index = find(self, set.key);
  if (!policy && index == kNone) {
    return SetDecision::refused({ErrorCode::kNotFound, fmt::format("{} has no tuple {}", number(self), set.key)});
  }
  if (!policy)
    return SetDecision::refused({ErrorCode::kRefused, fmt::format("{} is read-only for other components", set.key)});
  if (set.append && policy->scope != PolicyScope::kSetsAndAppends) {
    return SetDecision::refused(
        {ErrorCode::kRefused, fmt::format("{} accepts whole values only, not appends", set.key)});
  }
  const auto options = options_of(set);
  const auto fits =
      set.append ? check_append(set.key, index, set.value.size(), options) : check_sequence(set.key, index, options);
  return fits ? policy->policy(set) : SetDecision::refused(fits.error());
}

Reply TupleSpace::Impl::answer(const RemoteSet& set, std::shared_ptr<const RemoteSet>& meant) {
  auto decision = set.time_to_live < Duration(0)
                      ? SetDecision{Verdict::kExpired,
                                    false,
                                    ErrorCode::kExpired,
                                    "the time to live ended before the owner received the request",
                                    {}}
                      : decide(set);
  const bool store_it = decision.verdict == Verdict::kApplied && decision.store;
  auto index = kNone;
  if (store_it) {
    const auto stored = set.append ? append(set.key, set.value, options_of(set), set.from)
                                   : write(set.key, set.value, options_of(set), set.from);
    if (stored) index = stored->index;
    if (!stored) decision = SetDecision::refused(stored.error());
  }
  meant = std::move(decision.meant);
  Reply reply{set.from, set.request, decision.verdict, decision.code, std::move(decision.text)};
  if (index == kNone && (store_it || set.expected_sequence)) index = find(self, set.key);
  if (index != kNone) reply.sequence = store.at(index).sequence;
  return reply;
}

void TupleSpace::Impl::answer_own(RemoteSet set) {
  const auto remaining = requests.remaining(set.request);
  if (!remaining) return;
  // Exactly zero remains: pass a negative time, because zero means that none was given.
  set.time_to_live = *remaining > Duration(0) ? *remaining : Duration(-1);
  std::shared_ptr<const RemoteSet> meant;
  requests.answer(self, answer(set, meant));
}

}  // namespace rubicon::tuples
