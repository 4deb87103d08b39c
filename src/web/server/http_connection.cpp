#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/error.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <cctype>

#include "base/scheduler.h"
#include "web/exchange.h"
#include "web/server/connection.h"
#include "web/server/http_text.h"
#include "web/server/peer_stream.h"

namespace rubicon::web::server {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using boost::system::error_code;

constexpr std::size_t kPiece = 4096;

std::string lower_case(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

/// The answer to what could not be read as a request; nullopt where the connection broke.
std::optional<Response> refusal(const error_code& error) {
  if (error == http::error::header_limit || error == http::error::buffer_overflow)
    return error_response(431, ErrorCode::kOutOfRange, "the head of the request is too long");
  if (error == http::error::body_limit)
    return error_response(413, ErrorCode::kOutOfRange, "the body of the request is too long");
  if (error == http::error::bad_version)
    return error_response(505, ErrorCode::kUnsupported, "this server speaks HTTP/1.1");
  if (error == http::error::end_of_stream || error == http::error::partial_message) return std::nullopt;
  if (error.category() != http::make_error_code(http::error::bad_method).category()) return std::nullopt;
  return error_response(400, ErrorCode::kInvalid, "this is no HTTP request: " + error.message());
}

class HttpConnection final : public AcceptedConnection, public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(ConnectionHost& host, std::unique_ptr<PeerStream> stream)
      : host_(host),
        limits_(host.limits()),
        address_(stream->address()),
        stream_(std::move(stream)),
        buffer_(limits_.head + kPiece),
        deadline_(host.scheduler(), [this] { too_late(); }),
        send_watch_(host.scheduler(), limits_.stalled, [this] { end(); }),
        respond_(host.scheduler(), [this] { send(std::move(response_)); }) {}
  ~HttpConnection() override { HttpConnection::abort(); }
  HttpConnection(const HttpConnection&) = delete;
  HttpConnection& operator=(const HttpConnection&) = delete;

  /// With a refusal no request is read.
  void start(std::optional<Response> refusal = {}) {
    refusal_ = std::move(refusal);
    if (!stream_->secure()) return begin();
    stage_ = Stage::kHandshake;
    deadline_.set(limits_.handshake);
    stream_->async_wait_for_bytes([self = shared_from_this()](const error_code& error) {
      if (self->ended_) return;
      if (error) return self->end();
      if (self->stream_->begins_tls()) return self->shake_hands();
      self->stream_->leave_tls();
      self->refuse(error_response(400, ErrorCode::kInvalid,
                                  "this port speaks HTTPS: expected https:// in front of the address"));
    });
  }

  bool idle() const override {
    switch (stage_) {
      case Stage::kHandshake:
      case Stage::kIdle:
      case Stage::kHead:
      case Stage::kLinger: return true;
      case Stage::kBody: return request_.caller.role == Role::kNone;
      case Stage::kHandedOver: return successor_ && successor_->idle();
      case Stage::kAnswer:
      case Stage::kSend: break;
    }
    return false;
  }
  const std::string& address() const override { return address_; }
  std::uint64_t session() const override { return session_; }

  void abort() override {
    if (std::exchange(ended_, true)) return;
    close();
  }

 private:
  enum class Stage : std::uint8_t { kHandshake, kIdle, kHead, kBody, kAnswer, kSend, kLinger, kHandedOver };
  using Parser = http::request_parser<http::string_body>;

  void shake_hands() {
    stream_->async_handshake([self = shared_from_this()](const error_code& error) {
      if (self->ended_) return;
      if (error) return self->end();
      self->begin();
    });
  }

  void begin() {
    if (refusal_) return refuse(std::move(*refusal_));
    await_request(limits_.head_time);
  }

  void close() {
    deadline_.clear();
    send_watch_.done();
    exchange_.reset();
    if (successor_) successor_->abort();
    if (stream_) stream_->close();
  }

  void end() {
    if (std::exchange(ended_, true)) return;
    const auto self = shared_from_this();
    close();
    host_.closed(*this);
  }

  /// A client that is slow in asking is answered only if it began to.
  void too_late() {
    if (stage_ == Stage::kAnswer)
      return refuse(error_response(504, ErrorCode::kExpired, "there was no answer in time"));
    if (stage_ != Stage::kHead && stage_ != Stage::kBody) return end();
    refuse(error_response(408, ErrorCode::kExpired, "the request took too long"));
  }

  void await_request(Duration patience) {
    parser_.reset();
    request_ = {};
    if (buffer_.size() > 0) return read_head();
    stage_ = Stage::kIdle;
    deadline_.set(patience);
    stream_->async_read_some(buffer_.prepare(kPiece),
                             [self = shared_from_this()](const error_code& error, std::size_t size) {
                               if (self->ended_) return;
                               if (error) return self->end();
                               self->buffer_.commit(size);
                               self->read_head();
                             });
  }

  void read_head() {
    stage_ = Stage::kHead;
    deadline_.set(limits_.head_time);
    parser_.emplace();
    parser_->header_limit(static_cast<std::uint32_t>(limits_.head));
    parser_->body_limit(limits_.upload);  // until the head says what it is
    reading_ = true;
    http::async_read_header(*stream_, buffer_, *parser_,
                            [self = shared_from_this()](const error_code& error, std::size_t) {
                              self->reading_ = false;
                              if (!self->ended_ && self->stage_ == Stage::kHead) self->take_head(error);
                            });
  }

  void take_head(const error_code& error) {
    if (error) return broken(error);
    if (auto wrong = read_request()) return refuse(std::move(*wrong));
    if (auto refused = host_.admit(request_, stream_->secure())) return refuse(std::move(*refused));
    if (asks_for_socket()) return open_socket();
    if (parser_->is_done()) return answer();
    if (auto refused = bound_body()) return refuse(std::move(*refused));
    stage_ = Stage::kBody;
    deadline_.set(upload_ ? limits_.upload_time : limits_.body_time);
    if (lower_case(request_.header("expect")) == "100-continue") return let_continue();
    read_body();
  }

  /// How long the body may be. Long ones are uploads, one at a time.
  std::optional<Response> bound_body() {
    const auto length = parser_->content_length();
    const bool takes_file = host_.takes_file(request_);
    if (takes_file) upload_ = host_.begin_upload();
    if (takes_file && !upload_)
      return error_response({ErrorCode::kBusy, "another file is being uploaded: try again later"});
    if (!upload_) parser_->body_limit(limits_.body);
    if (!upload_ && length && *length > limits_.body)
      return error_response(413, ErrorCode::kOutOfRange, "the body of the request is too long");
    return std::nullopt;
  }

  /// RFC 9110, section 10.1.1.
  void let_continue() {
    static constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
    asio::async_write(*stream_, asio::buffer(kContinue),
                      [self = shared_from_this()](const error_code& error, std::size_t) {
                        if (self->ended_ || self->stage_ != Stage::kBody) return;
                        if (error) return self->end();
                        self->read_body();
                      });
  }

  void read_body() {
    reading_ = true;
    http::async_read(*stream_, buffer_, *parser_, [self = shared_from_this()](const error_code& error, std::size_t) {
      self->reading_ = false;
      if (self->ended_ || self->stage_ != Stage::kBody) return;
      if (error) return self->broken(error);
      self->request_.body = std::move(self->parser_->get().body());
      self->answer();
    });
  }

  void broken(const error_code& error) {
    auto response = refusal(error);
    if (!response) return end();
    refuse(std::move(*response));
  }

  /// Parser -> request; what is wrong with it.
  std::optional<Response> read_request() {
    const auto& message = parser_->get();
    head_only_ = message.method() == http::verb::head;
    request_.method = head_only_ ? "GET" : message.method_string();
    if (message.target().size() > limits_.target)
      return error_response(414, ErrorCode::kOutOfRange, "the request target is too long");
    auto target = parse_target(message.target());
    if (!target) return error_response(400, ErrorCode::kInvalid, target.error().text);
    request_.path = std::move(target->path);
    request_.query = std::move(target->query);
    request_.caller.peer = stream_->address();
    for (const auto& field : message) request_.headers.emplace_back(lower_case(field.name_string()), field.value());
    if (auto wrong = body_fault(message.version())) return wrong;
    const auto is_host = [](const auto& field) { return field.first == "host"; };
    const auto hosts = std::count_if(request_.headers.begin(), request_.headers.end(), is_host);
    if (hosts > 1 || (hosts == 0 && message.version() > 10))
      return error_response(400, ErrorCode::kInvalid, "expected one Host field");
    // The absolute form replaces Host (RFC 9112, section 3.2.2).
    if (!target->authority.empty()) {
      std::erase_if(request_.headers, is_host);
      request_.headers.emplace_back("host", std::move(target->authority));
    }
    return std::nullopt;
  }

  /// A body whose end the parser does not know would be read as the next request (RFC 9112, sections 6.1 and 11.2).
  std::optional<Response> body_fault(unsigned version) const {
    const auto count = [this](std::string_view name) {
      return std::count_if(request_.headers.begin(), request_.headers.end(),
                           [&](const auto& one) { return one.first == name; });
    };
    const auto codings = count("transfer-encoding"), lengths = count("content-length");
    if (lengths > 1 || (codings > 0 && (lengths > 0 || version < 11)))
      return error_response(400, ErrorCode::kInvalid,
                            "expected one Content-Length, or Transfer-Encoding with HTTP/1.1");
    if (codings > 1 || (codings == 1 && lower_case(request_.header("transfer-encoding")) != "chunked"))
      return error_response(501, ErrorCode::kUnsupported, "the only transfer coding is chunked");
    return std::nullopt;
  }

  bool asks_for_socket() const {
    return request_.method == "GET" && lower_case(request_.header("upgrade")) == "websocket";
  }

  /// A client sends nothing before our answer (RFC 6455, section 4.1).
  void open_socket() {
    if (request_.path != kSocketPath)
      return refuse(error_response(404, ErrorCode::kNotFound, "there is no WebSocket here"));
    if (buffer_.size() > 0) return refuse(error_response(400, ErrorCode::kInvalid, "bytes before the WebSocket"));
    stage_ = Stage::kHandedOver;
    deadline_.clear();
    session_ = request_.caller.session;
    successor_ = serve_socket(host_, std::move(stream_), std::move(request_), [this] { end(); });
  }

  void answer() {
    stage_ = Stage::kAnswer;
    deadline_.set(limits_.answer);
    keep_alive_ = parser_->get().keep_alive();
    const auto round = ++round_;
    auto exchange =
        host_.answer(request_, [weak = weak_from_this(), round, watch = lifetime_.watch()](Response response) {
          const auto self = watch.ended() ? nullptr : weak.lock();
          if (self && self->round_ == round) self->respond(std::move(response));
        });
    if (stage_ == Stage::kAnswer) exchange_ = std::move(exchange);
  }

  void respond(Response response) {
    ++round_;           // one answer to one request,
    deadline_.clear();  // and none of our own beside it
    response_ = std::move(response);
    respond_.request();
  }

  /// The rest of the request is not read.
  void refuse(Response response) {
    ++round_;
    keep_alive_ = false;
    send(std::move(response));
  }

  void send(Response response) {
    if (ended_) return;
    exchange_.reset();
    upload_.reset();
    request_.body = {};
    stage_ = Stage::kSend;
    deadline_.clear();
    const bool known = parser_ && parser_->is_header_done();
    const bool new_version = !known || parser_->get().version() > 10;
    if (response.stream && !head_only_) return hand_over(response, new_version);
    const Framing framing{.keep_alive = keep_alive_, .head_only = head_only_, .secure = stream_->secure()};
    head_ = head_text(response, framing, host_.scheduler().wall_now());
    body_ = framing.head_only ? std::string() : std::move(response.body);
    send_watch_.begin(*stream_);
    const std::array<asio::const_buffer, 2> parts{asio::buffer(head_), asio::buffer(body_)};
    asio::async_write(*stream_, parts, [self = shared_from_this()](const error_code& error, std::size_t) {
      if (self->ended_) return;
      self->send_watch_.done();
      self->sent(error);
    });
  }

  void sent(const error_code& error) {
    if (error) return end();
    head_.clear();
    body_ = {};
    if (keep_alive_) return await_request(limits_.idle);
    if (reading_) return end();  // it was too slow: there is nothing unread
    stage_ = Stage::kLinger;
    deadline_.set(limits_.linger);
    stream_->end_sending();
    discard();
  }

  /// Closing with unread bytes would reset the connection, and the client might lose the answer (RFC 9112,
  /// section 9.6).
  void discard() {
    buffer_.clear();
    stream_->async_read_some(buffer_.prepare(kPiece),
                             [self = shared_from_this()](const error_code& error, std::size_t) {
                               if (self->ended_) return;
                               if (error) return self->end();
                               self->discard();
                             });
  }

  void hand_over(const Response& response, bool new_version) {
    stage_ = Stage::kHandedOver;
    session_ = request_.caller.session;
    const Framing framing{.keep_alive = false, .chunked = new_version, .secure = stream_->secure()};
    auto head = head_text(response, framing, host_.scheduler().wall_now());
    successor_ =
        serve_events(host_, std::move(stream_), std::move(head), new_version, response.stream, [this] { end(); });
  }

  ConnectionHost& host_;
  const Limits& limits_;
  std::string address_;
  std::unique_ptr<PeerStream> stream_;
  beast::flat_buffer buffer_;
  std::optional<Parser> parser_;
  Request request_;
  std::optional<Response> refusal_;
  Response response_;
  std::string head_, body_;
  std::unique_ptr<Exchange> exchange_;
  std::shared_ptr<void> upload_;  ///< while a file comes and is answered
  std::shared_ptr<Connection> successor_;
  Stage stage_ = Stage::kIdle;
  bool keep_alive_ = false;
  bool head_only_ = false;  ///< the request is HEAD, which is answered as GET without the body
  bool reading_ = false;    ///< a part of a request is awaited
  bool ended_ = false;
  std::uint64_t session_ = 0;  ///< of the conversation
  std::uint64_t round_ = 0;    ///< changes when a request is answered
  base::Deadline deadline_;
  StalledSend send_watch_;
  base::OncePerTurn respond_;
  base::Lifetime lifetime_;
};

}  // namespace

std::shared_ptr<AcceptedConnection> serve_http(ConnectionHost& host, std::unique_ptr<PeerStream> stream) {
  auto connection = std::make_shared<HttpConnection>(host, std::move(stream));
  connection->start();
  return connection;
}

std::shared_ptr<AcceptedConnection> refuse_http(ConnectionHost& host, std::unique_ptr<PeerStream> stream,
                                                Response response) {
  auto connection = std::make_shared<HttpConnection>(host, std::move(stream));
  connection->start(std::move(response));
  return connection;
}

}  // namespace rubicon::web::server
