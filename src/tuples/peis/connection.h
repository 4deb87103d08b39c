#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "base/scheduler.h"
#include "transport/transports.h"
#include "tuples/peis/own_messages.h"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

/// A package as it came; the body refers to the stream that it was read from.
struct Package {
  PackageHeader header;
  ByteView body;
};

/// Cuts the bytes of one direction of a connection into the connect message and packages (peis.md, section 3.4). Holds
/// at most what was appended last and one incomplete package before it.
class PackageStream {
 public:
  /// Adds received bytes; only after next() or connect() has returned nullopt. Ends the views of all packages.
  void append(ByteView bytes);

  /// The connect message that the initiator sends first; nullopt while it is incomplete. Any error is final: the
  /// connection must be closed.
  Result<std::optional<ConnectMessage>> connect();
  /// The next whole package, valid until append(); nullopt while it is incomplete. Any error is final.
  Result<std::optional<Package>> next();

  /// Ends the views of the packages that were taken, and gives back what they needed. An island has hundreds of
  /// connections, most of which are silent.
  void shed() { base::drop_front(buffer_, std::exchange(begin_, 0)); }

  /// Bytes of an incomplete package.
  std::size_t pending() const { return buffer_.size() - begin_; }

 private:
  ByteView rest() const { return ByteView(buffer_).subspan(begin_); }

  Bytes buffer_;
  std::size_t begin_ = 0;
  std::optional<Error> fault_;
};

/// Why a connection ended.
enum class Ending {
  kFailed,   ///< not established, reset, or closed by the other end
  kStrange,  ///< what came is no PEIS of this network
  kSilent,   ///< nothing came for the time limit
  kStuck,    ///< the other end's system took nothing for 2 s
  kRefused,  ///< greeted() refused it
};

/// Called from the loop, never inside a call to the connection. None may destroy the connection.
struct ConnectionCallbacks {
  /// Established, by us.
  std::function<void()> connected;
  /// The connect message of the other end, which has established it; false refuses it.
  std::function<bool(const ConnectMessage&)> greeted;
  std::function<void(const Package&)> package;
  /// Once; nothing follows.
  std::function<void(Ending, Error)> closed;
  /// There is room again after send() returned false.
  std::function<void()> room;
  /// Nothing was sent to a component of ours for a third of the lease.
  std::function<void()> quiet;
};

/// One TCP connection of the PEIS network (peis.md, sections 3.3 and 6.2): connect message, packages in both
/// directions, limits of time and bytes. To a kernel each package is one write, and at most 20,000 bytes wait in the
/// sockets: else its stream locks up. To components of ours bytes are written in blocks.
class Connection {
 public:
  static constexpr std::size_t kMaxPackages = 512;      ///< that wait for a kernel
  static constexpr std::size_t kMaxBlock = 256 * 1024;  ///< bytes that wait for a component of ours
  static constexpr Duration kConnectTime = std::chrono::seconds(3);
  static constexpr Duration kGreetingTime = std::chrono::seconds(3);  ///< to the first bytes of the other end
  static constexpr Duration kStuckTime = std::chrono::seconds(2);

  Connection(Scheduler& scheduler, ConnectionCallbacks calls);
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection();

  /// Establishes it. As Transports::open_tcp.
  Result<void> dial(transport::Transports& transports, const transport::Endpoint& to, const ConnectMessage& own);
  /// The other end has established it.
  transport::TcpCallbacks accept(std::unique_ptr<transport::TcpStream> stream);

  /// Takes a package, whose counter is set when it is written. Urgent ones overtake others. False: too much waits.
  bool send(ByteView package, bool urgent);
  /// The other end is a component of ours: writes in blocks; its silence ends the connection after its lease. quiet()
  /// is called so that our silence does not.
  void widen(Duration lease, Duration own_lease);
  /// Sends what waits as far as the system takes it, and closes. No calls follow.
  void close();

  bool is_open() const { return state_ == State::kOpen; }
  SteadyTime heard() const { return heard_; }
  transport::Endpoint local() const { return stream_ ? stream_->local() : transport::Endpoint(); }
  transport::Endpoint remote() const { return remote_; }
  std::uint64_t bytes_in() const { return bytes_in_; }
  std::uint64_t bytes_out() const { return bytes_out_; }
  std::size_t unacknowledged() const { return stream_ ? stream_->unacknowledged() : 0; }
  /// Packages that wait to be written to a kernel.
  std::size_t waiting() const { return urgent_.size() + normal_.size(); }

 private:
  enum class State { kConnecting, kAccepting, kOpen, kClosed };

  transport::TcpCallbacks stream_calls();
  void established();
  void received(ByteView bytes);
  bool take_connect();
  void take_packages();
  void write();
  bool write_next(std::deque<Bytes>& queue);
  void write_block();
  bool write(ByteView bytes);
  void tell_room();
  void watch_progress();
  void check_progress();
  void check_silence();
  void check_quiet();
  void end(Ending why, Error error);

  Scheduler& scheduler_;
  ConnectionCallbacks callbacks_;
  State state_ = State::kConnecting;
  bool wide_ = false, refused_ = false, failing_ = false, closing_ = false;
  ConnectMessage own_;
  transport::Endpoint remote_;
  std::unique_ptr<transport::TcpStream> stream_;
  PackageStream packages_;
  std::deque<Bytes> urgent_, normal_;
  Bytes block_;
  std::uint32_t counter_ = 0;
  Duration silence_limit_ = kGreetingTime, quiet_limit_{};
  SteadyTime heard_{};
  std::uint64_t bytes_in_ = 0, bytes_out_ = 0, out_when_checked_ = 0;
  std::uint64_t acknowledged_ = 0;  ///< bytes, when progress was checked
  SteadyTime progress_{};
  Timer retry_;  ///< of writing
  base::Deadline silence_, quiet_, stuck_;
  base::OncePerTurn flush_;
  base::Lifetime lifetime_;
};

/// Checks a message that says another component has the id of this one, since the message may be forged: connects to
/// that component. A component closes a connection with its own id and sends nothing (section 6.4, 28). Bounded.
class IdCheck {
 public:
  static constexpr std::size_t kMaxQuestions = 8;  ///< at a time; others are not asked

  /// `confirmed` is called in a later turn than ask().
  IdCheck(Scheduler& scheduler, transport::Transports& transports, ConnectMessage own,
          std::function<void(const Identity&)> confirmed);

  void ask(const Identity& other, const std::vector<transport::Endpoint>& addresses);

 private:
  struct Question {
    Identity other;
    bool is_connected = false, is_over = false;
    std::unique_ptr<Connection> connection;
  };

  void ask(const Identity& other, const transport::Endpoint& address);
  void end(std::uint64_t id, bool is_there);

  Scheduler& scheduler_;
  transport::Transports& transports_;
  ConnectMessage own_;
  std::function<void(const Identity&)> confirmed_;
  std::map<std::uint64_t, Question> questions_;
  std::uint64_t last_ = 0;
  base::OncePerTurn cleaning_;
};

}  // namespace rubicon::tuples::peis
