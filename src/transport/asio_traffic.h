#pragma once

#include <fmt/format.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/post.hpp>
#include <cerrno>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "base/bytes.h"
#include "transport/sockets.h"

namespace rubicon::transport {

/// Implements a ByteStream on an Asio socket or descriptor: reading, holding, the send queue. Lives as long as an
/// operation is pending, which may be longer than the stream.
template <class Socket>
struct AsioTraffic : std::enable_shared_from_this<AsioTraffic<Socket>> {
  using ErrorCodeOfAsio = boost::system::error_code;
  static constexpr std::size_t kFirstRead = 8192, kMaxReadBytes = std::size_t{64} * 1024;  ///< bytes read at once

  /// `name` begins each error text ("TCP 127.0.0.1:9002"); `ended` is the text for the end of the stream.
  AsioTraffic(const boost::asio::any_io_executor& executor, std::string name_, std::string_view ended_,
              StreamCallbacks c)
      : socket(executor), name(std::move(name_)), ended(ended_), calls(std::move(c)) {}

  bool going() const { return alive && !lost; }
  std::size_t waits() const { return queue.size() - written; }

  Error trouble(std::string_view doing, const ErrorCodeOfAsio& error) const {
    return {ErrorCode::kIo, fmt::format("{}: cannot {}: {}", name, doing, error.message())};
  }

  /// The connection is established.
  void begin() {
    connected = true;
    receive();
    if (!queue.empty()) flush({});
    if (going() && calls.connected) calls.connected();
  }

  void receive() {
    socket.async_read_some(boost::asio::buffer(buffer),
                           [self = this->shared_from_this()](const ErrorCodeOfAsio& error, std::size_t size) {
                             if (self->going()) self->received(error, size);
                           });
  }

  void received(const ErrorCodeOfAsio& error, std::size_t size) {
    if (error == boost::asio::error::eof || error.value() == EIO)
      return lose({ErrorCode::kUnreachable, fmt::format("{}: {}", name, ended)});
    if (error) return lose(trouble("receive", error));
    if (held) return void(kept = size);
    if (calls.received) calls.received(ByteView(buffer).first(size));
    if (!going()) return;
    fit_buffer(size);
    receive();
  }

  /// The buffer of the next read, after one of `size` bytes: larger if the other end sends faster, else smaller again.
  void fit_buffer(std::size_t size) {
    if (size == buffer.size() && size < kMaxReadBytes) {
      buffer.resize(2 * size);
    } else if (size < buffer.size() / 4 && buffer.size() > kFirstRead) {
      buffer = Bytes(buffer.size() / 2);
    }
  }

  /// Either one read is pending or its bytes are kept, so that hardly anything is read while held.
  void hold(bool hold) {
    if (std::exchange(held, hold) == hold || hold || kept == 0) return;
    boost::asio::post(socket.get_executor(), [self = this->shared_from_this()] {
      if (self->going() && !self->held && self->kept > 0) self->received({}, std::exchange(self->kept, 0));
    });
  }

  /// Writes as much as the system accepts at once.
  std::size_t write_some(ByteView bytes, ErrorCodeOfAsio& error) {
    std::size_t done = 0;
    while (done < bytes.size() && !error)
      done += socket.write_some(boost::asio::buffer(bytes.data() + done, bytes.size() - done), error);
    if (error == boost::asio::error::would_block || error == boost::asio::error::try_again) error = {};
    return done;
  }

  Result<void> send(ByteView bytes) {
    if (lost) return fail(ErrorCode::kUnreachable, name + ": cannot send: the connection is lost");
    if (waits() + bytes.size() > ByteStream::kMaxQueued)
      return fail(ErrorCode::kBusy,
                  fmt::format("{}: cannot send {} bytes: {} wait already", name, bytes.size(), waits()));
    ErrorCodeOfAsio error;
    const auto done = connected && waits() == 0 ? write_some(bytes, error) : 0;
    // A broken connection is reported in a later turn, by the pending read.
    if (error) return fail(ErrorCode::kUnreachable, trouble("send", error).text);
    queue.insert(queue.end(), bytes.begin() + static_cast<std::ptrdiff_t>(done), bytes.end());
    if (connected && !queue.empty()) flush_later();
    return {};
  }

  void flush_later() {
    if (std::exchange(waiting, true)) return;
    socket.async_wait(Socket::wait_write, [self = this->shared_from_this()](const ErrorCodeOfAsio& error) {
      self->waiting = false;
      if (self->going()) self->flush(error);
    });
  }

  void flush(const ErrorCodeOfAsio& waited) {
    ErrorCodeOfAsio error = waited;
    if (!error) written += write_some(ByteView(queue).subspan(written), error);
    if (error) return lose(trouble("send", error));
    base::drop_front(queue, std::exchange(written, 0));
    if (!queue.empty()) flush_later();
  }

  /// Closes the socket; no bytes and no calls follow.
  void end() {
    ErrorCodeOfAsio ignored;
    lost = true;
    connected = false;
    queue.clear();
    written = 0;
    socket.close(ignored);
  }

  void lose(Error why) {
    end();
    if (calls.failed) calls.failed(std::move(why));
  }

  /// The stream is destroyed.
  void leave() {
    ErrorCodeOfAsio ignored;
    alive = false;
    socket.close(ignored);
  }

  Socket socket;
  std::string name;
  std::string_view ended;
  StreamCallbacks calls;
  Bytes buffer = Bytes(kFirstRead);
  Bytes queue;  ///< from `written` on
  std::size_t written = 0;
  bool connected = false, lost = false, waiting = false, alive = true, held = false;
  std::size_t kept = 0;  ///< bytes in the buffer that arrived while held
};

}  // namespace rubicon::transport
