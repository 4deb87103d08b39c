#include "web/server/target.h"

#include <algorithm>
#include <cstdint>

#include "base/printable.h"
#include "base/text.h"

namespace rubicon::web::server {

namespace {

constexpr std::size_t kMostParameters = 256;

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
    if (!name || !value || fields.size() == kMostParameters) return std::nullopt;
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
  if (!target.path.starts_with('/')) return fail(ErrorCode::kInvalid, "the request target is no path");
  if (!percent_decoded(target.path)) return fail(ErrorCode::kInvalid, "the path is not percent-encoded UTF-8");
  auto query = parse_query(text.substr(std::min(question + 1, text.size())));
  if (!query) return fail(ErrorCode::kInvalid, "the query is not percent-encoded UTF-8, or has too many parameters");
  target.query = std::move(*query);
  return target;
}

}  // namespace rubicon::web::server
