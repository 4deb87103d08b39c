#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/websocket/stream.hpp>

#include "base/scheduler.h"
#include "base/text.h"
#include "web/server/connection.h"
#include "web/server/peer_stream.h"

namespace rubicon::web::server {

// Beast finds these by the type of the stream; the end of a WebSocket is the end of its connection.
void beast_close_socket(PeerStream& stream) {
  stream.close();
}

void teardown(boost::beast::role_type, PeerStream& stream, boost::system::error_code& error) {
  stream.end_sending();
  error = {};
}

template <class Done>
void async_teardown(boost::beast::role_type, PeerStream& stream, Done&& done) {
  stream.end_sending();
  boost::asio::post(stream.get_executor(),
                    [done = std::forward<Done>(done)]() mutable { done(boost::system::error_code()); });
}

namespace {

namespace websocket = boost::beast::websocket;
using websocket_error = boost::system::error_code;

/// Bytes of the reason in a close frame (RFC 6455, section 5.5).
constexpr std::size_t kMaxReasonLength = 123;

std::string cut_reason(std::string_view reason) {
  return std::string(reason.substr(0, base::utf8_prefix(reason.substr(0, kMaxReasonLength))));
}

class SocketConnection final : public Connection, public std::enable_shared_from_this<SocketConnection> {
 public:
  SocketConnection(ConnectionHost& host, std::unique_ptr<PeerStream> stream, Request request,
                   std::function<void()> ended)
      : host_(host),
        limits_(host.limits()),
        request_(std::move(request)),
        stream_(std::move(stream)),
        socket_(*stream_),
        ended_call_(std::move(ended)),
        deadline_(host.scheduler(), [this] { end(); }),
        send_watch_(host.scheduler(), limits_.stalled, [this] { end(); }),
        pump_(host.scheduler(), [this] { pump(); }) {}
  ~SocketConnection() override { SocketConnection::abort(); }
  SocketConnection(const SocketConnection&) = delete;
  SocketConnection& operator=(const SocketConnection&) = delete;

  void start() {
    websocket::permessage_deflate deflate;
    deflate.server_enable = host_.compress();
    deflate.memLevel = 4;
    deflate.server_max_window_bits = 12;
    socket_.set_option(deflate);
    socket_.read_message_max(limits_.message);
    websocket::request_type request{boost::beast::http::verb::get, request_.path, 11};
    for (const auto& [name, value] : request_.headers) request.insert(name, value);
    deadline_.set(limits_.head_time);
    socket_.async_accept(request, [self = shared_from_this()](const websocket_error& error) {
      if (self->ended_) return;
      if (error) return self->end();
      self->accepted();
    });
  }

  bool idle() const override { return !conversation_ || !conversation_->has_caller(); }

  void abort() override {
    if (std::exchange(ended_, true)) return;
    close();
  }

 private:
  void close() {
    deadline_.clear();
    ping_ = {};
    send_watch_.done();
    conversation_.reset();
    stream_->close();
  }

  void end() {
    if (ended_) return;
    const auto self = shared_from_this();
    abort();
    ended_call_();
  }

  void accepted() {
    deadline_.clear();
    socket_.text(true);
    socket_.auto_fragment(false);  // a frame of 64 KiB would be sixteen writes
    ConversationCallbacks calls;
    calls.wake = lifetime_.guard([this] { pump_.request(); });
    calls.close = [this, watch = lifetime_.watch()](std::string_view reason) {
      if (watch.ended()) return;
      lifetime_.post(host_.scheduler(), [this, text = cut_reason(reason)] { leave(text); });
    };
    conversation_ = host_.open(request_, std::move(calls));
    request_ = {};
    read();
    pump_.request();
    await_ping();
  }

  void read() {
    reading_ = true;
    socket_.async_read(incoming_, [self = shared_from_this()](const websocket_error& error, std::size_t) {
      self->reading_ = false;
      if (self->ended_) return;
      if (error) return self->end();
      self->received();
    });
  }

  void received() {
    if (leaving_) {
      incoming_.clear();
      return read();
    }
    if (!socket_.got_text()) return leave("expected text frames", websocket::close_code::unknown_data);
    ++ahead_;
    const auto text = boost::beast::buffers_to_string(incoming_.data());
    incoming_.consume(incoming_.size());
    conversation_->received(text);
    pump_.request();
    read_on();
  }

  /// A client that sends and takes nothing waits: its answers would have to be kept.
  void read_on() {
    if (!reading_ && (!writing_ || ahead_ < limits_.ahead)) read();
  }

  void pump() {
    if (ended_ || leaving_ || writing_ || !conversation_) return;
    auto frame = conversation_->next();
    if (!frame) return;
    outgoing_ = std::move(*frame);
    writing_ = true;
    ahead_ = 0;
    send_watch_.begin(*stream_);
    socket_.async_write(boost::asio::buffer(outgoing_),
                        [self = shared_from_this()](const websocket_error& error, std::size_t) {
                          if (!self->ended_) self->written(error);
                        });
  }

  void written(const websocket_error& error) {
    writing_ = false;
    send_watch_.done();
    if (error) return end();
    ahead_ = 0;
    read_on();
    pump_.request();
  }

  /// Programs that see nothing for a while learn that the server is there.
  void await_ping() {
    ping_ = host_.scheduler().after(limits_.ping, [this] {
      if (!writing_ && !leaving_ && !pinging_) ping();
      await_ping();
    });
  }

  void ping() {
    pinging_ = true;
    socket_.async_ping({}, [self = shared_from_this()](const websocket_error& error) {
      self->pinging_ = false;
      if (!self->ended_ && error) self->end();
    });
  }

  void leave(const std::string& reason, websocket::close_code code = websocket::close_code::policy_error) {
    if (ended_ || std::exchange(leaving_, true)) return;
    deadline_.set(limits_.linger);
    read_on();
    socket_.async_close({code, reason}, [self = shared_from_this()](const websocket_error&) { self->end(); });
  }

  ConnectionHost& host_;
  const Limits& limits_;
  Request request_;
  std::unique_ptr<PeerStream> stream_;
  websocket::stream<PeerStream&> socket_;
  std::function<void()> ended_call_;
  std::unique_ptr<Conversation> conversation_;
  boost::beast::flat_buffer incoming_;
  std::string outgoing_;
  std::size_t ahead_ = 0;  ///< messages read since the last write began or ended
  bool reading_ = false, writing_ = false, pinging_ = false;
  bool leaving_ = false, ended_ = false;
  base::Deadline deadline_;
  StalledSend send_watch_;
  Timer ping_;
  base::OncePerTurn pump_;
  base::Lifetime lifetime_;
};

}  // namespace

std::shared_ptr<Connection> serve_socket(ConnectionHost& host, std::unique_ptr<PeerStream> stream, Request request,
                                         std::function<void()> ended) {
  auto connection = std::make_shared<SocketConnection>(host, std::move(stream), std::move(request), std::move(ended));
  connection->start();
  return connection;
}

}  // namespace rubicon::web::server
