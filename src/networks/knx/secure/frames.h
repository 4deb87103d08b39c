#pragma once

#include <array>
#include <cstdint>

#include "networks/knx/secure/crypto.h"
#include "networks/knx/wire/blocks.h"
#include "networks/knx/wire/frame.h"

namespace rubicon::networks::knx::secure {

/// The frames of KNX IP Secure (KNX 3/8/9, AN159; knx.md, sections 10.2 and 10.3), without cryptography. read_x()
/// takes a frame of its service; kInvalid: its body has another length. Reserved bytes are written as 0 and not read.

/// Of a sender: any six bytes of its own.
using Serial = std::array<std::uint8_t, 6>;

/// SESSION_REQUEST 0951, 46 bytes.
struct SessionRequest {
  wire::Hpai control;  ///< over TCP: route back of TCP
  PublicKey public_key{};
};
Result<SessionRequest> read_session_request(const wire::Frame& frame);
Bytes write(const SessionRequest& request);

/// SESSION_RESPONSE 0952, 56 bytes.
struct SessionResponse {
  std::uint16_t session = 0;  ///< 0: the server has none to give; key and MAC may then be missing
  PublicKey public_key{};
  Block mac{};
};
Result<SessionResponse> read_session_response(const wire::Frame& frame);
Bytes write(const SessionResponse& response);

/// SESSION_AUTHENTICATE 0953, 24 bytes, in a wrapper.
struct SessionAuthenticate {
  std::uint8_t user = 0;
  Block mac{};
};
Result<SessionAuthenticate> read_session_authenticate(const wire::Frame& frame);
Bytes write(const SessionAuthenticate& authenticate);

/// SESSION_STATUS 0954, 8 bytes, in a wrapper.
enum class Status : std::uint8_t {
  kAuthenticated = 0,
  kAuthenticationFailed = 1,
  kUnauthenticated = 2,
  kTimeout = 3,
  kKeepAlive = 4,
  kClose = 5
};
/// Values that Status does not name are possible.
Result<Status> read_session_status(const wire::Frame& frame);
Bytes write(Status status);

/// TIMER_NOTIFY 0955, 36 bytes.
struct TimerNotify {
  std::uint64_t timer = 0;  ///< ms, 48 bits
  Serial serial{};
  std::uint16_t tag = 0;
  Block mac{};
};
Result<TimerNotify> read_timer_notify(const wire::Frame& frame);
Bytes write(const TimerNotify& notify);

/// What makes a wrapper unique; all of it travels in clear.
struct WrapperHead {
  std::uint16_t session = 0;  ///< 0 with routing
  /// 48 bits. Of a session: counts up from 0 in each direction; with routing: the timer in ms.
  std::uint64_t sequence = 0;
  Serial serial{};
  std::uint16_t tag = 0;  ///< 0 in a session
  friend bool operator==(const WrapperHead&, const WrapperHead&) = default;
};

/// SECURE_WRAPPER 0950, 38 bytes and the encrypted frame. Refers to the bytes it was read from.
struct Wrapper {
  WrapperHead head;
  ByteView content;  ///< encrypted
  ByteView mac;      ///< 16 bytes, encrypted
};
Result<Wrapper> read_wrapper(const wire::Frame& frame);

/// The blocks of a wrapper with `size` bytes of content, and of a TIMER_NOTIFY (timer as sequence, size 0).
Nonce nonce_of(const WrapperHead& head, std::size_t size);

/// Replaces `out` by the wrapper of a whole plain frame. Its memory is used again.
Result<void> seal_wrapper(Ccm& ccm, const Key& key, const WrapperHead& head, ByteView frame, Bytes& out);

enum class Opened : std::uint8_t {
  kFrame,     ///< authentic, and a well-formed frame
  kWrongMac,  ///< changed on the way, or of another key
  /// Authentic, but not a frame, or one that a wrapper must not hold: another wrapper, or a service of remote diagnosis
  /// and configuration (0740 to 0743).
  kForbidden
};
/// Replaces `frame` by the plain frame; it is empty unless the result is kFrame. Its memory is used again.
Result<Opened> open_wrapper(Ccm& ccm, const Key& key, const Wrapper& wrapper, Bytes& frame);

}  // namespace rubicon::networks::knx::secure
