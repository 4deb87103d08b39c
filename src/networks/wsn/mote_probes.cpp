#include "networks/wsn/mote_probes.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace rubicon::networks::wsn {

Result<void> MoteProbes::ask(std::uint16_t mote, DoneCall done) {
  const auto lost = lost_.find(mote);
  const bool is_lost = lost != lost_.end();
  if (is_lost && scheduler_.now() < lost->second.due)
    return fail(ErrorCode::kBusy, fmt::format("mote {} did not answer lately: it is asked ever less often", mote));
  if (!known_.insert(mote).second)
    return fail(ErrorCode::kDuplicate, fmt::format("mote {} is being asked already", mote));
  (is_lost ? lost_waiting_ : waiting_).push_back({mote, std::move(done), is_lost ? kAttempts - 1 : 0, is_lost});
  next();
  return {};
}

void MoteProbes::next() {
  while (under_way_ < kAtATime && !(waiting_.empty() && silent_.empty()))
    take_from(waiting_.empty() ? silent_ : waiting_);
  while (lost_under_way_ < kLostAtATime && !lost_waiting_.empty()) take_from(lost_waiting_);
}

void MoteProbes::take_from(std::deque<Question>& queue) {
  auto question = std::move(queue.front());
  queue.pop_front();
  if (put(question)) return;
  // No room: whoever asked hears of it now, and asks again in time.
  known_.erase(question.mote);
  question.done(DeliveryResult::kExpired);
}

bool MoteProbes::put(Question question) {
  auto request = probe_request(island_, question.mote);
  ++question.attempts;
  auto& under_way = question.lost ? lost_under_way_ : under_way_;
  request.done = [this, &under_way, question = std::move(question)](DeliveryResult how) {
    --under_way;
    ended(question, how);
    next();
  };
  if (!requests_.send(std::move(request))) return false;
  ++under_way;
  ++asked_;
  return true;
}

void MoteProbes::ended(Question question, DeliveryResult how) {
  const bool silent = how == DeliveryResult::kNoAnswer || how == DeliveryResult::kSinkSilent;
  if (silent && question.attempts < kAttempts) return silent_.push_back(std::move(question));
  known_.erase(question.mote);
  if (how == DeliveryResult::kNoAnswer) {
    auto& lost = lost_[question.mote];
    lost.pause = lost.pause == Duration::zero() ? kFirstPause : std::min(2 * lost.pause, kLongestPause);
    lost.due = scheduler_.now() + lost.pause;
  }
  question.done(how);
}

}  // namespace rubicon::networks::wsn
