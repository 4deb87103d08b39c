#include "networks/wsn/mote_probes.h"

#include <utility>

namespace rubicon::networks::wsn {

bool MoteProbes::ask(std::uint16_t mote, DoneCall done) {
  if (!known_.insert(mote).second) return false;
  waiting_.emplace_back(mote, std::move(done));
  next();
  return true;
}

void MoteProbes::next() {
  while (!waiting_.empty() && under_way_ < kAtATime) {
    auto [mote, done] = std::move(waiting_.front());
    waiting_.pop_front();
    auto request = probe_request(island_, mote);
    request.done = [this, mote = mote, done](Delivered how) {
      --under_way_;
      known_.erase(mote);
      done(how);
      next();
    };
    ++under_way_;
    if (requests_.send(std::move(request))) {
      ++asked_;
      continue;
    }
    // No room: whoever asked hears of it now, and asks again in time.
    --under_way_;
    known_.erase(mote);
    done(Delivered::kExpired);
  }
}

}  // namespace rubicon::networks::wsn
