#include "web/server/http_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <ctime>
#include <string_view>
#include <utility>

#include "base/clocks.h"
#include "base/text.h"

namespace rubicon::web::server {

namespace {

constexpr std::size_t kMaxParameters = 256;

bool is_plain(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c < '\x7f' && c != '#'; });
}

bool has_controls(std::string_view text) {
  return std::any_of(text.begin(), text.end(),
                     [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
}

/// A blank may be written as `+` in a query (WHATWG URL, application/x-www-form-urlencoded).
std::optional<std::string> query_decoded(std::string text) {
  std::replace(text.begin(), text.end(), '+', ' ');
  return percent_decoded(text);
}

std::optional<Fields> parse_query(std::string_view text) {
  Fields fields;
  while (!text.empty()) {
    const auto end = std::min(text.find('&'), text.size());
    const auto part = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (part.empty()) continue;
    const auto equals = std::min(part.find('='), part.size());
    auto name = query_decoded(std::string(part.substr(0, equals)));
    auto value = query_decoded(std::string(part.substr(std::min(equals + 1, part.size()))));
    if (!name || !value || fields.size() == kMaxParameters) return std::nullopt;
    fields.emplace_back(std::move(*name), std::move(*value));
  }
  return fields;
}

/// Takes `http://host` off the beginning; what is left is the path.
std::string take_authority(std::string_view& text) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (!text.starts_with(scheme)) continue;
    text.remove_prefix(scheme.size());
    const auto end = std::min(text.find_first_of("/?"), text.size());
    std::string authority(text.substr(0, end));
    text.remove_prefix(end);
    return authority;
  }
  return {};
}

}  // namespace

std::optional<std::string> percent_decoded(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      out += text[i];
      continue;
    }
    const auto digits = text.substr(i + 1, 2);
    const auto byte = digits.size() == 2 ? base::parse_hex_number<std::uint8_t>(digits) : std::nullopt;
    if (!byte) return std::nullopt;
    out += static_cast<char>(*byte);
    i += 2;
  }
  if (!base::is_utf8(out) || has_controls(out)) return std::nullopt;
  return out;
}

Result<Target> parse_target(std::string_view text) {
  if (!is_plain(text)) return fail(ErrorCode::kInvalid, "the request target has characters that no URL has");
  Target target;
  target.authority = take_authority(text);
  const auto question = std::min(text.find('?'), text.size());
  target.path = text.substr(0, question);
  if (target.path.empty() && !target.authority.empty()) target.path = "/";
  if (!target.path.starts_with('/')) return fail(ErrorCode::kInvalid, "the request target is not a path");
  if (!percent_decoded(target.path)) return fail(ErrorCode::kInvalid, "the path is not percent-encoded UTF-8");
  auto query = parse_query(text.substr(std::min(question + 1, text.size())));
  if (!query) return fail(ErrorCode::kInvalid, "the query is not percent-encoded UTF-8, or has too many parameters");
  target.query = std::move(*query);
  return target;
}

namespace {

// The page runs and loads only what this server sends. The page sets styles of single elements (plots, rows).
constexpr std::string_view kContentPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; connect-src "
    "'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// A browser that was here by https comes back by https only, for 30 days (RFC 6797).
constexpr std::string_view kOnlySecurely = "max-age=2592000";

std::string_view reason_of(unsigned status) {
  constexpr std::array<std::pair<unsigned, std::string_view>, 27> kReasons{{
      {200, "OK"},
      {201, "Created"},
      {202, "Accepted"},
      {204, "No Content"},
      {206, "Partial Content"},
      {303, "See Other"},
      {304, "Not Modified"},
      {400, "Bad Request"},
      {401, "Unauthorized"},
      {403, "Forbidden"},
      {404, "Not Found"},
      {405, "Method Not Allowed"},
      {406, "Not Acceptable"},
      {408, "Request Timeout"},
      {409, "Conflict"},
      {411, "Length Required"},
      {413, "Content Too Large"},
      {414, "URI Too Long"},
      {415, "Unsupported Media Type"},
      {429, "Too Many Requests"},
      {431, "Request Header Fields Too Large"},
      {500, "Internal Server Error"},
      {501, "Not Implemented"},
      {502, "Bad Gateway"},
      {503, "Service Unavailable"},
      {504, "Gateway Timeout"},
      {505, "HTTP Version Not Supported"},
  }};
  const auto found =
      std::find_if(kReasons.begin(), kReasons.end(), [=](const auto& one) { return one.first == status; });
  return found == kReasons.end() ? "Status" : found->second;
}

bool one_line_only(std::string_view text) {
  return std::none_of(text.begin(), text.end(), [](char c) { return c == '\r' || c == '\n' || c == '\0'; });
}

void add(std::string& text, std::string_view name, std::string_view value) {
  if (name.empty() || !one_line_only(name) || !one_line_only(value)) return;
  text += fmt::format("{}: {}\r\n", name, value);
}

bool has_body(unsigned status) {
  return status >= 200 && status != 204 && status != 304;
}

}  // namespace

std::string head_text(const Response& response, const Framing& framing, WallTime now) {
  auto text = fmt::format("HTTP/1.1 {} {}\r\n", response.status, reason_of(response.status));
  add(text, "Date", base::utc_text(now, "%a, %d %b %Y %H:%M:%S GMT"));
  add(text, "Content-Security-Policy", kContentPolicy);
  add(text, "X-Content-Type-Options", "nosniff");
  add(text, "Referrer-Policy", "no-referrer");
  add(text, "Cross-Origin-Resource-Policy", "same-origin");
  if (framing.secure) add(text, "Strict-Transport-Security", kOnlySecurely);
  const auto is_cache_rule = [](const auto& field) { return field.first == "Cache-Control"; };
  if (std::none_of(response.headers.begin(), response.headers.end(), is_cache_rule))
    add(text, "Cache-Control", "no-store");
  for (const auto& [name, value] : response.headers) add(text, name, value);
  if (!response.content_type.empty()) add(text, "Content-Type", response.content_type);
  if (framing.chunked) {
    add(text, "Transfer-Encoding", "chunked");
  } else if (!response.stream && has_body(response.status)) {
    add(text, "Content-Length", fmt::to_string(response.body.size()));
  }
  add(text, "Connection", framing.keep_alive ? "keep-alive" : "close");
  return text + "\r\n";
}

}  // namespace rubicon::web::server
