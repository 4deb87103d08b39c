#include "networks/wsn/mote_probes.h"

#include <algorithm>
#include <utility>

namespace rubicon::networks::wsn {

bool MoteProbes::ask(std::uint16_t mote, DoneCall done) {
  if (!known_.insert(mote).second && !give_up_silent(mote)) return false;
  waiting_.push_back({mote, std::move(done), 0});
  next();
  return true;
}

bool MoteProbes::give_up_silent(std::uint16_t mote) {
  const auto found = std::find_if(silent_.begin(), silent_.end(), [&](const auto& one) { return one.mote == mote; });
  if (found == silent_.end()) return false;
  const auto question = std::move(*found);
  silent_.erase(found);
  question.done(Delivered::kNoAnswer);
  return true;
}

void MoteProbes::next() {
  while (under_way_ < kAtATime && waiting() > 0) {
    auto& from = waiting_.empty() ? silent_ : waiting_;
    auto question = std::move(from.front());
    from.pop_front();
    if (put(question)) continue;
    // No room: whoever asked hears of it now, and asks again in time.
    known_.erase(question.mote);
    question.done(Delivered::kExpired);
  }
}

bool MoteProbes::put(Question question) {
  auto request = probe_request(island_, question.mote);
  ++question.attempts;
  request.done = [this, question = std::move(question)](Delivered how) {
    --under_way_;
    ended(question, how);
    next();
  };
  if (!requests_.send(std::move(request))) return false;
  ++under_way_;
  ++asked_;
  return true;
}

void MoteProbes::ended(Question question, Delivered how) {
  const bool silent = how == Delivered::kNoAnswer || how == Delivered::kSinkSilent;
  if (silent && question.attempts < kAttempts) return silent_.push_back(std::move(question));
  known_.erase(question.mote);
  question.done(how);
}

}  // namespace rubicon::networks::wsn
