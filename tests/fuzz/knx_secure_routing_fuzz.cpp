#include <algorithm>
#include <cstdlib>
#include <set>
#include <tuple>

#include "base/virtual_scheduler.h"
#include "fuzz_target.h"
#include "networks/knx/secure/routing_guard.h"

namespace rubicon::fuzz::knx_secure_routing_fuzz {

/// Input: records of a kind, a length (one byte each) and bytes. Kind 0: a datagram as it is. Kind 1: eight bytes of
/// timer, two of tag, then a frame, in an authentic wrapper. Kind 2: timer and tag of an authentic TIMER_NOTIFY, of our
/// own serial if the tag is odd. Others: so many times 10 ms pass. No wrapper is taken twice, nothing plain is taken,
/// and the timer never goes back.
FUZZ_TARGET(knx_secure_routing) {
  using namespace rubicon;
  using namespace rubicon::networks::knx;
  using namespace rubicon::networks::knx::secure;
  constexpr Serial kOwn{1}, kOther{2};
  const Key key(Bytes(Key::kSize, 7));
  VirtualScheduler time;
  Bytes notify;
  RoutingGuard guard(time, {key, std::chrono::seconds(1)}, {}, {std::chrono::seconds(1), kOwn, 1000, 1},
                     {[&](ByteView sent) { notify.assign(sent.begin(), sent.end()); }, [] {}, {}});
  guard.start();
  Ccm ccm;
  std::set<std::pair<std::uint64_t, std::uint16_t>> taken;
  std::uint64_t timer = 0;
  ByteView rest(data, size);
  while (rest.size() >= 2) {
    const auto kind = rest[0];
    const auto length = std::min<std::size_t>(rest[1], rest.size() - 2);
    const auto bytes = rest.subspan(2, length);
    rest = rest.subspan(2 + length);
    if (kind == 0) {
      const auto got = guard.receive("peer", bytes);
      const bool plain = !got.empty() && got.data() == bytes.data();
      if (plain && wire::read_frame(got)->service > wire::ServiceCode::kSearchResponseExtended) std::abort();
      continue;
    }
    if (kind > 2 || bytes.size() < 10) {
      time.run_for(std::chrono::milliseconds(10 * kind));
      continue;
    }
    std::uint64_t then = 0;
    for (std::size_t i = 0; i < 8; ++i) then = then << 8U | bytes[i];
    then &= RoutingClock::kMaxTimer;
    const auto tag = wire::u16_at(bytes, 8);
    Bytes datagram;
    if (kind == 1) {
      if (!seal_wrapper(ccm, key, {0, then, kOther, tag}, bytes.subspan(10), datagram)) std::abort();
      if (!guard.receive("peer", datagram).empty() && !taken.insert({then, tag}).second) std::abort();
    } else {
      TimerNotify made{then, tag % 2 ? kOwn : kOther, tag, {}};
      const auto header = write(made);
      const auto nonce = nonce_of({0, made.timer, made.serial, made.tag}, 0);
      if (!ccm.seal(key, nonce, ByteView(header).first(wire::kHeaderSize), {}, made.mac)) std::abort();
      if (!guard.receive("peer", write(made)).empty()) std::abort();
    }
    if (!guard.synchronised()) continue;
    const auto wrapped = guard.wrap(Bytes{6, 0x10, 2, 1, 0, 6});
    if (!wrapped && wrapped.error().text.find("at its end") == std::string::npos) std::abort();
    if (!wrapped) return 0;
    const auto now = read_wrapper(wire::read_frame(*wrapped).value())->head.sequence;
    if (now < timer) std::abort();
    timer = now;
  }
  return 0;
}

}  // namespace rubicon::fuzz::knx_secure_routing_fuzz
