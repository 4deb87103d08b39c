#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "base/scheduler.h"
#include "networks/knx/secure/session_channel.h"

namespace rubicon::knx_simulator {

/// Who may open a tunnel through KNX IP Secure.
struct SecureUser {
  std::uint8_t number = 2;
  networks::knx::secure::Key key;
  std::uint16_t address = 0;  ///< of the only tunnel of this user; 0 = any
};

struct SecureOptions {
  networks::knx::secure::Key device_code;
  std::vector<SecureUser> users;
  std::size_t sessions = 16;  ///< at a time
  bool required = true;       ///< refuses plain tunnels
  networks::knx::secure::Random random = networks::knx::secure::system_random();
};

/// From a text of lines: `device-password TEXT`, `user NUMBER any|ADDRESS TEXT`; a password reaches to the end of its
/// line. kInvalid names the line, never a password. Each password takes some 15 ms.
Result<SecureOptions> parse_secure_options(std::string_view text);

/// The sessions of a server of KNX IP Secure (KNX 3/8/9, AN159; knx.md, section 10.2), which keeps its rules strictly:
/// replays, changed and forbidden frames are dropped and counted. It knows no sockets: the caller names the connection
/// of a client by any pointer. The scheduler must outlive it.
class SecureSessions {
 public:
  /// Sends a frame to the client as it is. Must not call back.
  using Reply = std::function<void(ByteView frame)>;

  struct Opened {
    std::uint16_t session = 0;
    Bytes frame;
  };

  /// `ended`: a session was ended by either side; its tunnels must end.
  SecureSessions(Scheduler& scheduler, SecureOptions options, std::function<void(std::uint16_t session)> ended);
  SecureSessions(const SecureSessions&) = delete;
  SecureSessions& operator=(const SecureSessions&) = delete;

  const SecureOptions& options() const { return options_; }
  std::size_t size() const { return sessions_.size(); }

  /// A SESSION_REQUEST.
  void request(const networks::knx::wire::Frame& frame, Reply reply, const void* connection);
  /// A SECURE_WRAPPER. Returns a frame for the tunnels; what concerns the session is answered here.
  std::optional<Opened> unwrap(const networks::knx::wire::Frame& frame);
  /// A frame wrapped for the client of a session; empty if there is no such session.
  Bytes wrap(std::uint16_t session, ByteView frame);
  /// The user of an authenticated session; nullptr otherwise.
  const SecureUser* user_of(std::uint16_t session) const;
  /// The connection of these sessions is gone.
  void lose(const void* connection);
  /// Ends all sessions with this status, or without a message.
  void end_all(std::optional<networks::knx::secure::Status> status);

  // For tests: faults, and what a client cannot see.

  std::optional<networks::knx::secure::Key> other_device_code;  ///< proves another identity
  std::uint8_t unknown_user_status = 1;                         ///< 2: as another server does
  bool answers_requests = true, answers_authentication = true;
  Duration silence = std::chrono::seconds(60);          ///< ends an authenticated session
  Duration unauthenticated = std::chrono::seconds(10);  ///< ends any other

  struct Counters {
    std::uint64_t requests = 0, authenticated = 0, refused = 0, replays = 0, wrong_mac = 0, forbidden = 0,
                  other_sessions = 0, keep_alives = 0, closes = 0, timeouts = 0;
  };
  Counters counters;

 private:
  struct Session {
    Session(networks::knx::secure::SessionChannel own, Scheduler& scheduler, std::function<void()> silent)
        : channel(std::move(own)), silence(scheduler, std::move(silent)) {}
    networks::knx::secure::SessionChannel channel;
    networks::knx::secure::PublicKey client{}, server{};
    Reply reply;
    const void* connection = nullptr;
    const SecureUser* user = nullptr;
    base::Deadline silence;
  };
  using SessionPtr = std::shared_ptr<Session>;

  void refuse(const Reply& reply) const;
  Result<void> agree(const networks::knx::secure::PublicKey& client, Reply reply, const void* connection);
  void take(std::uint16_t id, Session& session, const networks::knx::wire::Frame& frame);
  void authenticate(std::uint16_t id, Session& session, const networks::knx::wire::Frame& frame);
  bool proves(Session& session, const SecureUser& user, const networks::knx::secure::Block& mac);
  bool count(networks::knx::secure::SessionChannel::Verdict verdict);
  void tell(Session& session, networks::knx::secure::Status status);
  void end(std::uint16_t id, std::optional<networks::knx::secure::Status> status);

  Scheduler& scheduler_;
  SecureOptions options_;
  std::function<void(std::uint16_t)> ended_;
  networks::knx::secure::Ccm ccm_;
  std::map<std::uint16_t, SessionPtr> sessions_;
  std::uint16_t last_id_ = 0;
};

}  // namespace rubicon::knx_simulator
