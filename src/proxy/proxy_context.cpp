#include "proxy/proxy_context.h"

namespace rubicon::proxy {

const Moment& TurnClock::refresh() {
  moment_ = {scheduler_.now(), scheduler_.wall_now()};
  fresh_ = true;
  end_of_turn_.request();
  return moment_;
}

}  // namespace rubicon::proxy
