#include "networks/knx/secure/session_channel.h"

#include <utility>

#include "networks/knx/secure/frames.h"

namespace rubicon::networks::knx::secure {

namespace {

/// Of a frame whose MAC covers its header, two bytes and both public keys. Its lengths are those of section 10.2.
Result<Block> handshake_mac(Ccm& ccm, const Key& key, wire::ServiceCode service, std::uint8_t length,
                            std::uint16_t two_bytes, const PublicKey& client, const PublicKey& server) {
  Bytes associated;
  wire::open_frame(associated, service);
  associated[5] = length;
  wire::write_u16(associated, two_bytes);
  for (std::size_t i = 0; i < client.size(); ++i)
    associated.push_back(static_cast<std::uint8_t>(client[i] ^ server[i]));
  Nonce nonce;
  nonce.c0[14] = 0xff;
  Block mac{};
  if (auto sealed = ccm.seal(key, nonce, associated, {}, mac); !sealed) return fail(sealed.error());
  return mac;
}

}  // namespace

Result<Key> session_key(const Secret& shared) {
  auto digest = sha256(shared.view());
  if (!digest) return fail(digest.error());
  Key key{ByteView(*digest)};
  wipe(*digest);
  return key;
}

Result<Block> response_mac(Ccm& ccm, const Key& device, std::uint16_t session, const PublicKey& client,
                           const PublicKey& server) {
  return handshake_mac(ccm, device, wire::ServiceCode::kSessionResponse, 0x38, session, client, server);
}

Result<Block> authenticate_mac(Ccm& ccm, const Key& user_key, std::uint8_t user, const PublicKey& client,
                               const PublicKey& server) {
  return handshake_mac(ccm, user_key, wire::ServiceCode::kSessionAuthenticate, 0x18, user, client, server);
}

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
