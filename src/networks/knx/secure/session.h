#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "base/scheduler.h"
#include "networks/knx/secure/line_keys.h"
#include "networks/knx/secure/session_channel.h"

namespace rubicon::networks::knx::secure {

/// Counters of all sessions that a line has opened one after another. What they count was dropped, unless noted.
struct SessionCounters {
  std::uint64_t sessions = 0;          ///< authenticated ones; not dropped
  std::uint64_t unverified = 0;        ///< of these, with a server that we cannot verify (no device password)
  std::uint64_t plain_frames = 0;      ///< not wrapped
  std::uint64_t early_frames = 0;      ///< wrapped, before the session was authenticated
  std::uint64_t wrong_mac = 0;         ///< changed on the way, or of another key
  std::uint64_t replays = 0;           ///< a sequence number again, or our own wrapper
  std::uint64_t other_sessions = 0;    ///< of another session
  std::uint64_t forbidden_frames = 0;  ///< content that a wrapper of a server must not have
  std::uint64_t bad_frames = 0;        ///< malformed
};

/// A session of KNX IP Secure with a server, from SESSION_REQUEST to its end, as client: the state machine (KNX 3/8/9,
/// AN159; knx.md, sections 10.2 and 21), without sockets. Frames of the server enter by receive() and leave by
/// `transmit`; the plain frames of the tunnel inside leave by `received` and enter by send(). Each callback is the last
/// action of the function that makes it, so the session may be destroyed in `up`, `received`, `note` and `ended`, but
/// not in `transmit`.
class Session {
 public:
  enum class Cause : std::uint8_t {
    kNoneFree,  ///< the server has no session to give: try again later
    /// It does not know the device password: not the device that we want. Configuration. Over UDP this and kNoneFree
    /// come only when the time for the handshake is over: anybody can send a datagram in the server's name.
    kWrongServer,
    kNotAuthenticated,  ///< it does not accept user or password. Configuration.
    kNoAnswer,          ///< the handshake was not complete in time
    kClosed,            ///< by the server
    kForgotten,         ///< the server no longer accepts the session
    kBroken             ///< our own cryptography failed
  };
  struct End {
    Cause cause{};
    std::uint8_t status = 0;  ///< of a SESSION_STATUS
    std::string why;          ///< for the user

    /// For the reason, as Error has it.
    std::string_view finding() const;
  };

  struct Callbacks {
    std::function<void(ByteView frame)> transmit;
    std::function<void()> up;
    /// A plain frame that the server wrapped, valid during the call.
    std::function<void(ByteView frame)> received;
    /// An event that a counter counts too, for the log; may be empty. `subject` names the counter.
    std::function<void(const std::string& subject, std::string_view text)> note{};
    /// The last callback.
    std::function<void(End)> ended;
  };

  struct Settings {
    /// UDP only: repeats what may be lost. A repeated request asks for route back where `tries_route_back` says so.
    bool repeats = false;
    wire::Hpai own{};  ///< where the server sends its answers
    bool tries_route_back = false;
    std::size_t password_form = 0;  ///< of the user: an index for PasswordKey::form()
    Random random = system_random();
  };

  /// Scheduler, keys and counters must outlive it.
  Session(Scheduler& scheduler, const SessionKeys& keys, Settings settings, SessionCounters& counters,
          Callbacks callbacks);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Makes a key pair of its own and sends the request. Once.
  void start();
  /// One whole frame of the server.
  void receive(ByteView frame);
  /// A plain frame to wrap. Only when up().
  void send(ByteView frame);
  bool up() const { return phase_ == Phase::kUp; }
  /// Tells the server that the session ends; no callbacks afterwards.
  void close();

  /// Where the server sends its answers: Settings::own, or route back if only that worked.
  const wire::Hpai& own() const { return settings_.own; }
  /// The server is the device whose password we have.
  bool verified() const { return verified_; }

 private:
  enum class Phase : std::uint8_t { kNew, kRequested, kAuthenticating, kUp, kEnded };

  // To the server.
  void send_request();
  void send_authenticate();
  bool wrap(ByteView frame);
  void due();
  void keep_alive();
  void repeat();

  // From the server.
  void receive_response(const wire::Frame& frame);
  void reject_response(Cause cause, const std::string& why);
  Result<bool> verify(const SessionResponse& response);
  Result<void> agree(const SessionResponse& response);
  void receive_wrapper(const wire::Frame& frame);
  void receive_opened(SessionChannel::Verdict verdict);
  void receive_status(const wire::Frame& frame);
  void refused(Status status);
  void authenticated();
  void drop_opened(SessionChannel::Verdict verdict);
  void drop(std::uint64_t& counter, const char* subject, std::string_view text);
  Duration keep_alive_pause() const;

  void end(Cause cause, std::string why, std::uint8_t status = 0);
  void stop();
  const Key& user_key() const;

  Scheduler& scheduler_;
  const SessionKeys& keys_;
  Settings settings_;
  SessionCounters& counters_;
  Callbacks callbacks_;
  Phase phase_ = Phase::kNew;
  SteadyTime until_{};  ///< the handshake must be complete
  Ccm ccm_;
  std::optional<KeyPair> pair_;  ///< until both ends have the session key
  PublicKey own_public_{}, server_public_{};
  std::optional<SessionChannel> channel_;
  bool verified_ = false;
  std::optional<End> rejected_;  ///< what a response said that may have been forged
  base::Deadline deadline_;      ///< handshake: the next repeat; then the keep-alive
};

}  // namespace rubicon::networks::knx::secure
