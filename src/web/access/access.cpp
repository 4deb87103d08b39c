#include "web/access/access.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "base/text.h"
#include "model/json_members.h"
#include "web/error_response.h"

namespace rubicon::web::access {

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
