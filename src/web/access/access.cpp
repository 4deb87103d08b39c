#include "web/access/access.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <iterator>
#include <optional>
#include <utility>

#include "base/text.h"
#include "model/json_members.h"
#include "web/exchange.h"

namespace rubicon::web::access {

namespace {

constexpr std::size_t kNetworkBytes = 8;

/// An IPv4 address as it is; the network of an IPv6 address.
std::string host_of(const std::string& address) {
  in6_addr parsed{};
  if (::inet_pton(AF_INET6, address.c_str(), &parsed) != 1) return address;
  return {reinterpret_cast<const char*>(parsed.s6_addr), kNetworkBytes};
}

}  // namespace

bool Attempts::may_try(const std::string& address, SteadyTime now) {
  forget(now);
  const auto found = failures_.find(subject(address));
  return found == failures_.end() || found->second.size() < kMaxCount;
}

void Attempts::failed(const std::string& address, SteadyTime now) {
  forget(now);
  auto& times = failures_[subject(address)];
  times.push_back(now);
  if (times.size() > kMaxCount) times.pop_front();
}

std::string Attempts::subject(const std::string& address) const {
  auto host = host_of(address);
  const bool full = failures_.size() >= kMaxAddressCount && !failures_.contains(host);
  return full ? std::string() : host;
}

void Attempts::forget(SteadyTime now) {
  for (auto entry = failures_.begin(); entry != failures_.end();) {
    auto& times = entry->second;
    while (!times.empty() && now - times.front() >= kPeriod) times.pop_front();
    entry = times.empty() ? failures_.erase(entry) : std::next(entry);
  }
}

namespace {

constexpr std::uint16_t kHttp = 80;
constexpr std::uint16_t kHttps = 443;

std::string lowered(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

bool is_ip_address(const std::string& host) {
  in6_addr room{};
  return ::inet_pton(AF_INET, host.c_str(), &room) == 1 || ::inet_pton(AF_INET6, host.c_str(), &room) == 1;
}

bool has_member(const std::vector<std::string>& list, const std::string& lower) {
  return std::any_of(list.begin(), list.end(), [&](const auto& one) { return lowered(one) == lower; });
}

}  // namespace

bool OriginRules::is_own_host(std::string_view host) const {
  const auto parsed = base::parse_host_port(lowered(host), kHttp);
  if (!parsed) return false;
  return parsed->host == "localhost" || is_ip_address(parsed->host) || has_member(hosts, parsed->host);
}

bool OriginRules::is_own_origin(std::string_view origin, std::string_view host, bool secure) const {
  if (is_listed(origin)) return true;
  const std::string_view scheme = secure ? "https://" : "http://";
  const auto text = lowered(origin);
  if (!text.starts_with(scheme)) return false;
  const auto port = secure ? kHttps : kHttp;
  const auto theirs = base::parse_host_port(std::string_view(text).substr(scheme.size()), port);
  const auto ours = base::parse_host_port(lowered(host), port);
  return theirs && ours && *theirs == *ours;
}

bool OriginRules::is_listed(std::string_view origin) const {
  return has_member(origins, lowered(origin));
}

std::string Sessions::open(const Digest& token, SteadyTime now) {
  if (sessions_.size() >= kMaxCount) {
    sessions_.erase(std::min_element(sessions_.begin(), sessions_.end(),
                                     [](const auto& a, const auto& b) { return a.second.used < b.second.used; }));
  }
  auto secret = random_secret();
  sessions_[sha256(secret)] = {++last_id_, token, now, now};
  return secret;
}

const Sessions::Session* Sessions::find(std::string_view secret, SteadyTime now) {
  // Looked up by the digest: how long that takes says nothing about the secret.
  return renew(sessions_.find(sha256(secret)), now);
}

bool Sessions::renew(std::uint64_t id, SteadyTime now) {
  return renew(std::find_if(sessions_.begin(), sessions_.end(),
                            [id](const auto& entry) { return entry.second.id == id; }),
               now) != nullptr;
}

const Sessions::Session* Sessions::renew(Place place, SteadyTime now) {
  if (place == sessions_.end()) return nullptr;
  auto& session = place->second;
  if (now - session.used >= kIdle || now - session.opened >= kMaxTime) {
    sessions_.erase(place);
    return nullptr;
  }
  session.used = now;
  return &session;
}

void Sessions::close(std::string_view secret) {
  sessions_.erase(sha256(secret));
}

void Sessions::keep_only(const std::vector<Digest>& known) {
  std::erase_if(sessions_, [&known](const auto& entry) {
    return std::find(known.begin(), known.end(), entry.second.token) == known.end();
  });
}

namespace {

constexpr std::string_view kBearer = "bearer ";

bool changes_something(const Request& request) {
  return request.method != "GET" && request.method != "HEAD" && request.method != "OPTIONS";
}

/// A page of another site makes the browser ask, which sends no Origin where that page cannot read the answer (Fetch
/// standard, no-cors). Asking may wake sensors.
bool comes_from_elsewhere(const Request& request) {
  const auto site = request.header("sec-fetch-site");  // W3C Fetch Metadata Request Headers
  return site == "cross-site" || site == "same-site";
}

bool starts_with_word(std::string_view text, std::string_view lower) {
  return text.size() >= lower.size() && std::equal(lower.begin(), lower.end(), text.begin(), [](char a, char b) {
           return a == (b >= 'A' && b <= 'Z' ? static_cast<char>(b - 'A' + 'a') : b);
         });
}

}  // namespace

bool Access::take(std::vector<Token> tokens) {
  const auto before = std::exchange(tokens_, std::move(tokens));
  std::vector<Digest> hashes;
  for (const auto& token : tokens_) hashes.push_back(token.hash);
  sessions_.keep_only(hashes);
  return std::any_of(before.begin(), before.end(), [this](const Token& token) {
    return std::find(tokens_.begin(), tokens_.end(), token) == tokens_.end();
  });
}

void Access::name_cookie(std::uint16_t port, bool secure) {
  // The prefix: only this host can have set it, and only by TLS (RFC 6265bis, section 4.1.3.2).
  rules_.cookie = fmt::format("{}rubicon-{}", secure ? "__Host-" : "", port);
}

Result<Caller> Access::by_token(std::string_view token, const std::string& peer) {
  if (const auto* found = find(sha256(token))) return Caller{found->name, found->role, peer, 0, found->roles};
  const auto now = scheduler_.now();
  if (!attempts_.may_try(peer, now))
    return fail(ErrorCode::kBusy, "too many wrong tokens from this address; wait a minute");
  attempts_.failed(peer, now);
  return fail(ErrorCode::kRefused, "no such token");
}

std::optional<Response> Access::admit(Request& request, bool secure) {
  if (!rules_.origins.is_own_host(request.header("host")))
    return error_response(403, ErrorCode::kRefused,
                          "Host is neither an IP address, nor localhost, nor one of `hosts` in the configuration");
  if (auto refused = check_origin(request, secure)) return refused;
  return name_caller(request);
}

std::optional<Response> Access::check_origin(const Request& request, bool secure) const {
  const auto origin = request.header("origin");
  if (is_site_path(request.path) && comes_from_elsewhere(request) && !rules_.origins.is_listed(origin))
    return error_response(403, ErrorCode::kRefused, "a page of another site asked for this");
  const bool matters = changes_something(request) || !request.header("upgrade").empty();
  if (!matters || origin.empty()) return std::nullopt;
  if (rules_.origins.is_own_origin(origin, request.header("host"), secure)) return std::nullopt;
  return error_response(403, ErrorCode::kRefused,
                        "Origin is not this server's; `origins` in the configuration lists others");
}

std::optional<Response> Access::name_caller(Request& request) {
  const auto peer = request.caller.peer;
  if (!rules_.needs_token) {
    request.caller = {"local", Role::kAdmin, peer};
    return std::nullopt;
  }
  request.caller = {"", Role::kNone, peer};
  if (const auto field = request.header("authorization"); starts_with_word(field, kBearer)) {
    auto caller = by_token(base::trimmed(field.substr(kBearer.size())), peer);
    if (!caller) return refusal_of(caller.error());
    request.caller = std::move(*caller);
    return std::nullopt;
  }
  const auto* session = sessions_.find(cookie_of(request), scheduler_.now());
  if (const auto* token = session ? find(session->token) : nullptr)
    request.caller = {token->name, token->role, peer, session->id, token->roles};
  return std::nullopt;
}

Response Access::session(const Request& request, bool secure) {
  if (request.method == "POST") return log_in(request, secure);
  if (request.method != "DELETE") {
    auto response = error_response(405, ErrorCode::kUnsupported, "expected POST or DELETE");
    response.headers = {{"Allow", "POST, DELETE"}};
    return response;
  }
  sessions_.close(cookie_of(request));
  return {.status = 204, .headers = {{"Set-Cookie", cookie_text("", secure) + "; Max-Age=0"}}};
}

Response Access::log_in(const Request& request, bool secure) {
  Response response{.content_type = "application/json"};
  auto caller = Result<Caller>(request.caller);
  if (rules_.needs_token) {
    const auto token = model::text_of(model::object_of(request.body), "token");
    caller = by_token(token, request.caller.peer);
    if (!caller) return refusal_of(caller.error());
    sessions_.close(cookie_of(request));  // the browser forgets it now
    const auto secret = sessions_.open(sha256(token), scheduler_.now());
    const bool behind_tls = request.header("origin").starts_with("https://");  // of a proxy
    response.headers.emplace_back("Set-Cookie", cookie_text(secret, secure || behind_tls));
  }
  response.body = model::dump({{"caller", {{"name", caller->name}, {"role", to_string(caller->role)}}}});
  return response;
}

std::string Access::cookie_of(const Request& request) const {
  auto text = request.header("cookie");
  while (!text.empty()) {
    const auto end = std::min(text.find(';'), text.size());
    const auto pair = base::trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    const auto equals = pair.find('=');
    if (equals != pair.npos && pair.substr(0, equals) == rules_.cookie) return std::string(pair.substr(equals + 1));
  }
  return {};
}

std::string Access::cookie_text(std::string_view secret, bool secure) const {
  return fmt::format("{}={}; HttpOnly; SameSite=Strict; Path=/{}", rules_.cookie, secret, secure ? "; Secure" : "");
}

Fields Access::origin_fields(const Request& request) const {
  if (rules_.origins.origins.empty()) return {};
  const auto origin = request.header("origin");
  if (!rules_.origins.is_listed(origin)) return {{"Vary", "Origin"}};
  return {{"Vary", "Origin"}, {"Access-Control-Allow-Origin", std::string(origin)}};
}

bool Access::renew_session(std::uint64_t id) {
  return sessions_.renew(id, scheduler_.now());
}

const Token* Access::find(const Digest& hash) const {
  const Token* found = nullptr;
  for (const auto& known : tokens_) {  // all of them: the time does not tell which
    if (same(known.hash, hash)) found = &known;
  }
  return found;
}

}  // namespace rubicon::web::access
