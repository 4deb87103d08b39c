#include "web/server/server.h"

#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/ssl/context.hpp>
#include <cerrno>
#include <ctime>
#include <map>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "base/log.h"
#include "web/exchange.h"
#include "web/server/connection.h"
#include "web/server/listener.h"
#include "web/server/peer_stream.h"

namespace rubicon::web::server {

namespace {

/// What OpenSSL said last about a file, which is the least technical.
tl::unexpected<Error> file_error(std::string_view option, const std::string& path) {
  if (::access(path.c_str(), R_OK) != 0) {
    const int error = errno;
    return fail(error == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo,
                fmt::format("{} {}: cannot read: {}", option, path, std::generic_category().message(error)));
  }
  const char* reason = ::ERR_reason_error_string(::ERR_peek_last_error());
  ::ERR_clear_error();
  return fail(ErrorCode::kInvalid, fmt::format("{} {}: {}", option, path, reason == nullptr ? "not usable" : reason));
}

/// OpenSSL's own callback asks at the terminal and blocks.
int refuse_passphrase(char*, int, int, void*) {
  return 0;
}

WallTime end_of(const X509* certificate) {
  std::tm time{};
  if (certificate == nullptr || ::ASN1_TIME_to_tm(::X509_get0_notAfter(certificate), &time) != 1) return {};
  return std::chrono::floor<WallTime::duration>(std::chrono::system_clock::from_time_t(::timegm(&time)));
}

}  // namespace

Result<TlsSetup> read_tls(const TlsFiles& files) {
  // At the end of the process a thread may still be in the library.
  [[maybe_unused]] static const int once = ::OPENSSL_init_ssl(OPENSSL_INIT_NO_ATEXIT, nullptr);
  auto context = std::make_shared<boost::asio::ssl::context>(boost::asio::ssl::context::tls_server);
  auto* native = context->native_handle();
  SSL_CTX_set_min_proto_version(native, TLS1_2_VERSION);
  SSL_CTX_set_mode(native, SSL_MODE_RELEASE_BUFFERS);
  ::SSL_CTX_set_options(native, SSL_OP_NO_RENEGOTIATION | SSL_OP_CIPHER_SERVER_PREFERENCE);
  ::SSL_CTX_set_default_passwd_cb(native, refuse_passphrase);
  ::ERR_clear_error();
  if (::SSL_CTX_use_certificate_chain_file(native, files.certificate.c_str()) != 1)
    return file_error("certificate", files.certificate);
  if (::SSL_CTX_use_PrivateKey_file(native, files.key.c_str(), SSL_FILETYPE_PEM) != 1 ||
      ::SSL_CTX_check_private_key(native) != 1)
    return file_error("key", files.key);
  const auto expires = end_of(::SSL_CTX_get0_certificate(native));
  return TlsSetup{std::move(context), expires};
}

namespace {

constexpr std::string_view kSessionPath = "/api/v1/session";
/// A certificate that ends within this time is worth a line in the log.
constexpr Duration kExpirySoon = std::chrono::hours(24 * 14);
constexpr Duration kExpiryLook = std::chrono::hours(24);
constexpr Duration kSessionLook = std::chrono::minutes(1);

/// What a client without a token may know: that it needs one, and that the server works.
bool is_public(std::string_view path) {
  return path == "/api/v1" || path == "/healthz" || path == kSessionPath || path == kSocketPath || !is_site_path(path);
}

}  // namespace

class Server::Impl final : public ConnectionHost {
 public:
  Impl(const Parts& parts, ServerOptions options)
      : parts_(parts), options_(std::move(options)), log_(parts.log, parts.scheduler) {}
  ~Impl() override { disconnect(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Result<void> open() {
    std::optional<TlsSetup> tls;
    if (options_.tls) {
      auto read = read_tls(*options_.tls);
      if (!read) return fail(read.error());
      tls = std::move(*read);
    }
    Listener::Callbacks calls;
    calls.accepted = [this](std::unique_ptr<PeerStream> stream) { take(std::move(stream)); };
    calls.failed = [this](const Error& error) { parts_.log.error("no more connections are accepted: " + error.text); };
    auto listener = Listener::open(parts_.context, parts_.scheduler, options_.listen, std::move(calls));
    if (!listener) return fail(listener.error());
    listener_ = std::move(*listener);
    if (tls) use(std::move(*tls));
    if (parts_.access.rules().needs_token) look_at_sessions();
    return {};
  }

  Result<void> reload() {
    if (!options_.tls) return {};
    auto tls = read_tls(*options_.tls);
    if (!tls) return fail(tls.error());
    use(std::move(*tls));
    return {};
  }

  void disconnect() {
    for (const auto& connection : std::exchange(connections_, {})) connection->abort();
    for (const auto& connection : std::exchange(refused_, {})) connection->abort();
  }

  std::optional<Response> admit(Request& head, bool secure) override {
    ++counters_.requests;
    auto refused = parts_.access.admit(head, secure);
    if (!refused && head.caller.role == Role::kNone && !is_public(head.path) && head.method != "OPTIONS")
      refused = refusal_of({ErrorCode::kRefused, "this needs a token"});
    if (!refused) return std::nullopt;
    ++counters_.refused;
    log_.info(head.caller.peer, fmt::format("refused a request of {}: {}", head.caller.peer, refused->status));
    return refused;
  }

  std::unique_ptr<Exchange> answer(const Request& request, Respond respond) override {
    auto with_origin = [fields = parts_.access.origin_fields(request),
                        respond = std::move(respond)](Response response) {
      response.headers.insert(response.headers.end(), fields.begin(), fields.end());
      respond(std::move(response));
    };
    if (request.method == "OPTIONS") return with_origin(preflight(request)), nullptr;
    if (request.path == kSessionPath) {
      with_origin(parts_.access.session(request, secure()));
      end_conversations();
      return nullptr;
    }
    if (request.path == kSocketPath)
      return with_origin(error_response(426, ErrorCode::kUnsupported, "this is the address of a WebSocket")), nullptr;
    if (is_site_path(request.path)) return parts_.site.handle(request, std::move(with_origin));
    return with_origin(file(request)), nullptr;
  }

  bool takes_file(const Request& head) const override { return parts_.site.takes_file(head); }
  std::shared_ptr<void> begin_upload() override {
    if (!upload_.expired()) return nullptr;
    auto begun = std::make_shared<int>();
    upload_ = begun;
    return begun;
  }

  std::unique_ptr<Conversation> open(const Request& request, ConversationCallbacks calls) override {
    return parts_.site.open(request.caller, std::move(calls));
  }

  void closed(Connection& connection) override {
    const auto is_it = [&](const auto& one) { return one.get() == &connection; };
    std::erase_if(connections_, is_it);
    std::erase_if(refused_, is_it);
  }

  const Limits& limits() const override { return options_.limits; }
  Scheduler& scheduler() override { return parts_.scheduler; }
  bool compress() const override { return options_.compress; }

  transport::Endpoint local() const { return listener_->local(); }
  bool secure() const { return options_.tls.has_value(); }
  std::size_t connections() const { return connections_.size(); }
  const ServerCounters& counters() const { return counters_; }

 private:
  void take(std::unique_ptr<PeerStream> stream) {
    ++counters_.accepted;
    if (connections_.size() >= options_.limits.connections && !make_room()) {
      ++counters_.turned_away;
      log_.warning("room", fmt::format("{} connections are open, more are turned away", connections_.size()));
      return turn_away(std::move(stream));
    }
    connections_.push_back(serve_http(*this, std::move(stream)));
  }

  /// Of the connections that ask nothing the oldest goes, of the address that has most connections: one client cannot
  /// displace the others.
  bool make_room() {
    std::map<std::string_view, std::size_t> of_address;
    for (const auto& one : connections_) ++of_address[one->address()];
    const AcceptedConnection* chosen = nullptr;
    for (const auto& one : connections_) {
      if (one->idle() && (!chosen || of_address[one->address()] > of_address[chosen->address()])) chosen = one.get();
    }
    if (chosen) close_where([chosen](const AcceptedConnection& one) { return &one == chosen; });
    return chosen != nullptr;
  }

  /// A browser shows the answer, where a connection that is only closed looks like a broken network.
  void turn_away(std::unique_ptr<PeerStream> stream) {
    if (refused_.size() >= options_.limits.refused) return;
    auto response = error_response(503, ErrorCode::kBusy, "too many connections are open; try again later");
    response.headers.emplace_back("Retry-After", "10");
    refused_.push_back(refuse_http(*this, std::move(stream), std::move(response)));
  }

  /// Those of sessions that have ended. The others count as use of theirs.
  void end_conversations() {
    close_where([this](const AcceptedConnection& one) {
      const auto session = one.session();
      return session != 0 && !parts_.access.renew_session(session);
    });
  }

  void look_at_sessions() {
    end_conversations();
    session_look_ = parts_.scheduler.after(kSessionLook, [this] { look_at_sessions(); });
  }

  template <class Test>
  void close_where(Test test) {
    std::vector<std::shared_ptr<AcceptedConnection>> closing;
    for (const auto& one : connections_) {
      if (test(*one)) closing.push_back(one);
    }
    for (const auto& one : closing) {
      std::erase(connections_, one);
      one->abort();
    }
  }

  void use(TlsSetup tls) {
    listener_->set_tls(std::move(tls.context));
    expires_ = tls.expires;
    look_at_expiry();
  }

  void look_at_expiry() {
    const auto now = parts_.scheduler.wall_now();
    const auto& file = options_.tls->certificate;
    if (expires_ <= now) {
      parts_.log.warning(
          fmt::format("certificate {} has expired: browsers refuse the page; put a new one there and reload", file));
    } else if (expires_ - now < kExpirySoon) {
      const auto hours = std::chrono::duration_cast<std::chrono::hours>(expires_ - now).count();
      parts_.log.warning(fmt::format("certificate {} expires in {} h", file, hours));
    }
    expiry_look_ = parts_.scheduler.after(kExpiryLook, [this] { look_at_expiry(); });
  }

  Response file(const Request& request) const {
    if (request.method != "GET" && request.method != "HEAD") {
      auto response = error_response(405, ErrorCode::kUnsupported, "expected GET or HEAD");
      response.headers = {{"Allow", "GET, HEAD"}};
      return response;
    }
    auto found = parts_.page.find(request);
    return found ? std::move(*found) : error_response(404, ErrorCode::kNotFound, "there is no such file");
  }

  /// Only pages of listed origins get an answer that their browser accepts (Fetch standard, CORS-preflight).
  Response preflight(const Request& request) const {
    Response response{.status = 204, .headers = {{"Allow", "GET, HEAD, POST, PUT, DELETE, OPTIONS"}}};
    if (parts_.access.rules().origins.is_listed(request.header("origin"))) {
      response.headers.emplace_back("Access-Control-Allow-Methods", "GET, POST, PUT, DELETE");
      response.headers.emplace_back("Access-Control-Allow-Headers", "authorization, content-type");
    }
    return response;
  }

  Parts parts_;
  ServerOptions options_;
  base::LimitedLog log_;
  ServerCounters counters_;
  std::vector<std::shared_ptr<AcceptedConnection>> connections_;  ///< the oldest first
  std::vector<std::shared_ptr<AcceptedConnection>> refused_;      ///< get an answer that there is no room
  std::weak_ptr<void> upload_;
  std::unique_ptr<Listener> listener_;
  WallTime expires_{};
  Timer expiry_look_, session_look_;
};

Result<std::unique_ptr<Server>> Server::open(const Parts& parts, ServerOptions options) {
  auto impl = std::make_unique<Impl>(parts, std::move(options));
  if (auto opened = impl->open(); !opened) return fail(opened.error());
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Server::~Server() = default;

transport::Endpoint Server::local() const {
  return impl_->local();
}
bool Server::secure() const {
  return impl_->secure();
}
Result<void> Server::reload() {
  return impl_->reload();
}
void Server::disconnect() {
  impl_->disconnect();
}
std::size_t Server::connections() const {
  return impl_->connections();
}
const ServerCounters& Server::counters() const {
  return impl_->counters();
}

}  // namespace rubicon::web::server
