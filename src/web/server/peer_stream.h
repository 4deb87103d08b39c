#pragma once

#include <sys/socket.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "base/scheduler.h"

namespace rubicon::web::server {

/// An accepted connection, plain or by TLS, as Asio's and Beast's operations expect a stream. Destroying or closing it
/// ends their waiting.
class PeerStream {
 public:
  using Socket = boost::asio::ip::tcp::socket;
  using executor_type = Socket::executor_type;
  using error_code = boost::system::error_code;

  /// No context = plain.
  PeerStream(Socket socket, std::string address, std::shared_ptr<boost::asio::ssl::context> context)
      : socket_(std::move(socket)), address_(std::move(address)), context_(std::move(context)) {
    if (context_) tls_.emplace(socket_, *context_);
  }
  PeerStream(const PeerStream&) = delete;
  PeerStream& operator=(const PeerStream&) = delete;

  executor_type get_executor() { return socket_.get_executor(); }
  bool secure() const { return tls_.has_value(); }
  /// IP address of the client.
  const std::string& address() const { return address_; }
  /// Bytes that the system took; grows while the client reads.
  std::uint64_t sent() const { return sent_; }

  void close() {
    error_code ignored;
    socket_.close(ignored);
  }
  /// Ends our direction; the client reads what was sent before.
  void end_sending() {
    error_code ignored;
    socket_.shutdown(Socket::shutdown_send, ignored);
  }

  /// Calls `done(error)` when the client has sent something, or closed.
  template <class Done>
  void async_wait_for_bytes(Done&& done) {
    socket_.async_wait(Socket::wait_read, std::forward<Done>(done));
  }
  /// Looks whether what the client sent begins a handshake (a record of type 22: RFC 8446, section 5.1); what is no
  /// byte at all ends with the handshake.
  bool begins_tls() {
    constexpr char kHandshake = 22;
    char first = 0;
    return ::recv(socket_.native_handle(), &first, 1, MSG_PEEK | MSG_DONTWAIT) != 1 || first == kHandshake;
  }
  /// Goes on without TLS, before a handshake.
  void leave_tls() { tls_.reset(); }

  template <class Done>
  void async_handshake(Done&& done) {
    tls_->async_handshake(boost::asio::ssl::stream_base::server, std::forward<Done>(done));
  }

  template <class Buffers, class Done>
  void async_read_some(const Buffers& buffers, Done&& done) {
    if (tls_) return static_cast<void>(tls_->async_read_some(buffers, std::forward<Done>(done)));
    socket_.async_read_some(buffers, std::forward<Done>(done));
  }

  template <class Buffers, class Done>
  void async_write_some(const Buffers& buffers, Done&& done) {
    auto counted = [this, done = std::forward<Done>(done)](const error_code& error, std::size_t size) mutable {
      sent_ += size;
      done(error, size);
    };
    if (tls_) return static_cast<void>(tls_->async_write_some(buffers, std::move(counted)));
    socket_.async_write_some(buffers, std::move(counted));
  }

 private:
  Socket socket_;
  std::string address_;
  std::shared_ptr<boost::asio::ssl::context> context_;
  std::optional<boost::asio::ssl::stream<Socket&>> tls_;
  std::uint64_t sent_ = 0;
};

/// Notices a client that takes nothing for `patience` while something is sent to it; looks six times in that time.
class StalledSend {
 public:
  StalledSend(Scheduler& scheduler, Duration patience, std::function<void()> stalled)
      : scheduler_(scheduler),
        patience_(patience),
        stalled_(std::move(stalled)),
        deadline_(scheduler, [this] { look(); }) {}

  /// Something is sent from now on, until done().
  void begin(const PeerStream& stream) {
    stream_ = &stream;
    progress();
  }
  void done() { deadline_.clear(); }

 private:
  void progress() {
    taken_ = stream_->sent();
    since_ = scheduler_.now();
    deadline_.set(patience_ / 6);
  }

  void look() {
    if (stream_->sent() != taken_) return progress();
    if (scheduler_.now() - since_ < patience_) return deadline_.set(patience_ / 6);
    const auto call = stalled_;  // it may destroy the owner of this
    call();
  }

  Scheduler& scheduler_;
  Duration patience_;
  std::function<void()> stalled_;
  const PeerStream* stream_ = nullptr;
  std::uint64_t taken_ = 0;
  SteadyTime since_{};  ///< of the last progress
  base::Deadline deadline_;
};

}  // namespace rubicon::web::server
