#include "networks/knx/secure/session_channel.h"

#include <utility>

namespace rubicon::networks::knx::secure {

SessionChannel::SessionChannel(std::uint16_t session, Key key, const Serial& own)
    : session_(session), key_(std::move(key)), own_(own) {}

Result<ByteView> SessionChannel::seal(Ccm& ccm, ByteView frame) {
  if (auto sealed = seal_wrapper(ccm, key_, {session_, next_, own_, 0}, frame, out_); !sealed)
    return fail(sealed.error());
  ++next_;  // 2^48 numbers are enough for any session
  return ByteView(out_);
}

Result<SessionChannel::Verdict> SessionChannel::open(Ccm& ccm, const Wrapper& wrapper) {
  in_.clear();
  if (wrapper.head.session != session_) return Verdict::kOtherSession;
  if (wrapper.head.serial == own_) return Verdict::kReflected;
  if (last_received_ && wrapper.head.sequence <= *last_received_) return Verdict::kReplayed;
  const auto opened = open_wrapper(ccm, key_, wrapper, in_);
  if (!opened) return fail(opened.error());
  if (*opened == Opened::kWrongMac) return Verdict::kWrongMac;
  last_received_ = wrapper.head.sequence;
  return *opened == Opened::kFrame ? Verdict::kFrame : Verdict::kForbidden;
}

}  // namespace rubicon::networks::knx::secure
