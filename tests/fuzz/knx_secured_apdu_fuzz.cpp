#include <cstdlib>

#include "base/virtual_scheduler.h"
#include "fuzz_target.h"
#include "networks/knx/secure/group_guard.h"

namespace rubicon::fuzz::knx_secured_apdu_fuzz {

namespace {

using namespace rubicon::networks::knx;

void require(bool condition) {
  if (!condition) std::abort();
}

/// The key 30..3f of knx.md, section 18.
secure::Key group_key() {
  secure::Key key;
  std::uint8_t next = 0x30;
  for (auto& byte : key.span()) byte = next++;
  return key;
}

secure::GroupKeys keys() {
  secure::GroupKeys all;
  all.groups[wire::GroupAddress(0x0a07)] = {group_key(), {wire::IndividualAddress(0x710b)}};
  return all;
}

/// What the bytes hold as a plain TPDU comes back from its secured form.
void check_round_trip(ByteView tpdu) {
  if (tpdu.size() < 2 || tpdu.size() > 241) return;
  secure::Ccm ccm;
  wire::DataFrame frame;
  frame.source = wire::IndividualAddress(0x710b);
  frame.destination = 0x0a07;
  frame.tpdu = tpdu;
  for (const auto control : {secure::control::kEncrypted, secure::control::kAuthenticated}) {
    const auto sealed = secure::seal(ccm, group_key(), frame, control, 5);
    require(sealed.has_value() && sealed->size() == tpdu.size() + secure::kSecurityBytes);
    auto closed = frame;
    closed.tpdu = *sealed;
    const auto opened = secure::open(ccm, group_key(), closed);
    require(opened.has_value() && std::equal(opened->begin(), opened->end(), tpdu.begin(), tpdu.end()));
  }
}

}  // namespace

/// Input: cEMI frames, each behind a byte with its length. A secured group never gives a plain telegram, and no frame
/// is accepted twice.
FUZZ_TARGET(knx_secured_apdu) {
  VirtualScheduler time;
  secure::GroupGuard guard(time, keys(), {}, wire::IndividualAddress(0x710c), {});
  ByteView rest(data, size);
  while (!rest.empty()) {
    const auto length = std::min<std::size_t>(rest[0], rest.size() - 1);
    const auto cemi = rest.subspan(1, length);
    rest = rest.subspan(1 + length);
    check_round_trip(cemi);
    const auto frame = wire::read_data_frame(cemi);
    if (!frame) continue;
    (void)guard.peek(*frame);
    const auto telegram = guard.open(*frame);
    if (telegram && guard.secures(telegram->destination)) {
      require(secure::is_secured(frame->tpdu));
      require(!guard.open(*frame));
    }
    if (!telegram)
      require((telegram.error().drop == secure::GroupGuard::Drop::kNoTelegram) == telegram.error().why.empty());
  }
  return 0;
}

}  // namespace rubicon::fuzz::knx_secured_apdu_fuzz
