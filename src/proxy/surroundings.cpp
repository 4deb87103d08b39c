#include "proxy/surroundings.h"

namespace rubicon::proxy {

const Moment& TurnClock::refresh() {
  moment_ = {scheduler_.now(), scheduler_.wall_now()};
  if (!*fresh_) {
    *fresh_ = true;
    scheduler_.post([fresh = std::weak_ptr(fresh_)] {
      if (const auto alive = fresh.lock()) *alive = false;
    });
  }
  return moment_;
}

void NextTurn::ask() {
  if (*asked_) return;
  *asked_ = true;
  scheduler_.post([call = std::weak_ptr(call_), asked = asked_] {
    *asked = false;
    if (const auto alive = call.lock()) (*alive)();
  });
}

}  // namespace rubicon::proxy
