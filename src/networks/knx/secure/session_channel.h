#pragma once

#include <cstdint>
#include <optional>

#include "networks/knx/secure/crypto.h"
#include "networks/knx/secure/frames.h"

namespace rubicon::networks::knx::secure {

/// The computations with which both ends of a session begin (knx.md, section 10.2; KNX 3/8/9).

/// The first 16 bytes of the SHA-256 of the shared secret.
Result<Key> session_key(const Secret& shared);

/// The MAC of SESSION_RESPONSE as transmitted. `device`: the device authentication code of the server.
Result<Block> response_mac(Ccm& ccm, const Key& device, std::uint16_t session, const PublicKey& client,
                           const PublicKey& server);

/// The MAC of SESSION_AUTHENTICATE as transmitted.
Result<Block> authenticate_mac(Ccm& ccm, const Key& user_key, std::uint8_t user, const PublicKey& client,
                               const PublicKey& server);

/// One end of an agreed session, client or server: wraps frames, and opens what the peer wraps (knx.md, section 10.2).
/// Both directions use one key; they differ by the serial numbers of the two ends.
class SessionChannel {
 public:
  /// What a received wrapper is. Only kFrame and kForbidden count as received.
  enum class Verdict : std::uint8_t {
    kFrame,
    kOtherSession,
    kReflected,  ///< our own wrapper, sent back
    kReplayed,   ///< its sequence number is not greater than the last accepted one
    kWrongMac,
    kForbidden  ///< Opened::kForbidden
  };

  SessionChannel(std::uint16_t session, Key key, const Serial& own);

  std::uint16_t session() const { return session_; }
  /// The wrapper of the next sequence number; valid until the next call.
  Result<ByteView> seal(Ccm& ccm, ByteView frame);
  /// The plain frame is then in opened().
  Result<Verdict> open(Ccm& ccm, const Wrapper& wrapper);
  /// Of the last open(); empty unless it was kFrame.
  ByteView opened() const { return in_; }

 private:
  std::uint16_t session_;
  Key key_;
  Serial own_;
  std::uint64_t next_ = 0;
  std::optional<std::uint64_t> last_received_;
  Bytes in_, out_;  ///< their memory is used again
};

}  // namespace rubicon::networks::knx::secure
