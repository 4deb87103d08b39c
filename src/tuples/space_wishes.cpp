#include <fmt/format.h>

#include "base/assert.h"
#include "tuples/space_impl.h"

namespace rubicon::tuples {

namespace {

SetOptions options_of(const RemoteSet& wish) {
  return {wish.media_type, wish.user_time, wish.lifetime, wish.expected_sequence};
}

}  // namespace

std::uint64_t TupleSpace::Impl::ask(RemoteSet wish, ReplyCall call) {
  RUBICON_DEBUG_ASSERT(scheduler.on_loop_thread());
  wish.from = self;
  const auto request = wish.request = requests.next_number();
  if (requests.full()) {
    later([request, me = self, call = std::move(call)] {
      if (call) call({me, request, Verdict::kRefused, ErrorCode::kBusy, "too many remote sets wait for their answer"});
    });
    return request;
  }
  requests.open(request, wish.time_to_live, std::move(call));
  send(std::move(wish));
  return request;
}

void TupleSpace::Impl::send(RemoteSet wish) {
  if (wish.owner == self) {
    later([this, wish = std::move(wish)] { judge_own(wish); });
  } else if (auto sent = link.remote_set(wish); !sent) {
    const auto verdict = sent.error().code == ErrorCode::kNotFound ? Verdict::kNoSuchOwner : Verdict::kRefused;
    later([this, reply = Reply{self, wish.request, verdict, sent.error().code, sent.error().text}] {
      requests.answer(reply);
    });
  }
}

SetDecision TupleSpace::Impl::decide(const RemoteSet& wish) {
  if (auto ok = model::check_key(wish.key); !ok) return SetDecision::refused(ok.error());
  if (wish.value.size() > kMaxValueSize) {
    return SetDecision::refused(
        {ErrorCode::kOutOfRange, fmt::format("the value for {} has {} bytes, at most {} are allowed", wish.key,
                                             wish.value.size(), kMaxValueSize)});
  }
  const auto policy = policies.find(self, wish.key);
  const auto index = find(self, wish.key);
  if (!policy && index == kNone) {
    return SetDecision::refused({ErrorCode::kNotFound, fmt::format("{} has no tuple {}", number(self), wish.key)});
  }
  if (!policy) return SetDecision::refused({ErrorCode::kRefused, fmt::format("{} is read-only for others", wish.key)});
  if (wish.append && policy->scope != PolicyScope::kSetsAndAppends) {
    return SetDecision::refused(
        {ErrorCode::kRefused, fmt::format("{} takes whole values, nothing can be appended", wish.key)});
  }
  const auto options = options_of(wish);
  const auto fits = wish.append ? check_append(wish.key, index, wish.value.size(), options)
                                : check_sequence(wish.key, index, options);
  return fits ? policy->policy(wish) : SetDecision::refused(fits.error());
}

Reply TupleSpace::Impl::judge(const RemoteSet& wish) {
  auto judgement = wish.time_to_live < Duration(0)
                       ? SetDecision{Verdict::kExpired, false, ErrorCode::kExpired, "the time to live ended on the way"}
                       : decide(wish);
  const bool store_it = judgement.verdict == Verdict::kApplied && judgement.store;
  if (store_it) {
    const auto stored = wish.append ? append(wish.key, wish.value, options_of(wish), wish.from)
                                    : write(wish.key, wish.value, options_of(wish), wish.from);
    if (!stored) judgement = SetDecision::refused(stored.error());
  }
  Reply reply{wish.from, wish.request, judgement.verdict, judgement.code, std::move(judgement.text)};
  const auto index = store_it || wish.expected_sequence ? find(self, wish.key) : kNone;
  if (index != kNone) reply.sequence = store.at(index).sequence;
  return reply;
}

void TupleSpace::Impl::judge_own(RemoteSet wish) {
  const auto left = requests.remaining(wish.request);
  if (!left) return;
  // What is not over by now may be over in this very moment: zero would mean that no time was given.
  wish.time_to_live = *left > Duration(0) ? *left : Duration(-1);
  requests.answer(judge(wish));
}

}  // namespace rubicon::tuples
