#include <fmt/format.h>

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/write.hpp>

#include "base/scheduler.h"
#include "web/server/connection.h"
#include "web/server/peer_stream.h"

namespace rubicon::web::server {

namespace {

using stream_error = boost::system::error_code;

class EventConnection final : public Connection, public std::enable_shared_from_this<EventConnection> {
 public:
  EventConnection(ConnectionHost& host, std::unique_ptr<PeerStream> stream, std::string head, bool chunked,
                  std::function<void()> ended)
      : stream_(std::move(stream)),
        outgoing_(std::move(head)),
        chunked_(chunked),
        scheduler_(host.scheduler()),
        ended_call_(std::move(ended)),
        send_watch_(scheduler_, host.limits().stalled, [this] { end(); }),
        pump_(scheduler_, [this] { pump(); }) {}
  ~EventConnection() override { EventConnection::abort(); }
  EventConnection(const EventConnection&) = delete;
  EventConnection& operator=(const EventConnection&) = delete;

  void start(const OpenConversation& open) {
    ConversationCallbacks calls;
    calls.wake = lifetime_.guard([this] { pump_.request(); });
    calls.close = [this, watch = lifetime_.watch()](std::string_view) {
      if (!watch.ended()) lifetime_.post(scheduler_, [this] { leave(); });
    };
    conversation_ = open(std::move(calls));
    await_end();
    write();
  }

  bool idle() const override { return false; }

  void abort() override {
    if (std::exchange(ended_, true)) return;
    send_watch_.done();
    conversation_.reset();
    stream_->close();
  }

 private:
  void end() {
    if (ended_) return;
    const auto self = shared_from_this();
    abort();
    ended_call_();
  }

  /// A client of a stream sends nothing more; reading shows that it left.
  void await_end() {
    stream_->async_read_some(boost::asio::buffer(ignored_),
                             [self = shared_from_this()](const stream_error& error, std::size_t) {
                               if (self->ended_) return;
                               if (error) return self->end();
                               self->await_end();
                             });
  }

  void pump() {
    if (ended_ || writing_) return;
    if (leaving_) return write_last();
    auto frame = conversation_ ? conversation_->next() : std::nullopt;
    if (!frame || frame->empty()) return;
    outgoing_ = chunked_ ? fmt::format("{:x}\r\n{}\r\n", frame->size(), *frame) : std::move(*frame);
    write();
  }

  void write() {
    writing_ = true;
    send_watch_.begin(*stream_);
    boost::asio::async_write(*stream_, boost::asio::buffer(outgoing_),
                             [self = shared_from_this()](const stream_error& error, std::size_t) {
                               if (self->ended_) return;
                               self->writing_ = false;
                               self->send_watch_.done();
                               if (error) return self->end();
                               self->pump_.request();
                             });
  }

  void leave() {
    leaving_ = true;
    pump();
  }

  /// The last chunk has no bytes (RFC 9112, section 7.1).
  void write_last() {
    if (!chunked_ || std::exchange(last_, true)) return end();
    outgoing_ = "0\r\n\r\n";
    write();
  }

  std::unique_ptr<PeerStream> stream_;
  std::string outgoing_;
  bool chunked_;
  Scheduler& scheduler_;
  std::function<void()> ended_call_;
  std::unique_ptr<Conversation> conversation_;
  std::array<char, 512> ignored_{};
  bool writing_ = false, leaving_ = false, last_ = false, ended_ = false;
  StalledSend send_watch_;
  base::OncePerTurn pump_;
  base::Lifetime lifetime_;
};

}  // namespace

std::shared_ptr<Connection> serve_events(ConnectionHost& host, std::unique_ptr<PeerStream> stream, std::string head,
                                         bool chunked, const OpenConversation& open, std::function<void()> ended) {
  auto connection =
      std::make_shared<EventConnection>(host, std::move(stream), std::move(head), chunked, std::move(ended));
  connection->start(open);
  return connection;
}

}  // namespace rubicon::web::server
