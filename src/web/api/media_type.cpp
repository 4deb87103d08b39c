#include "web/api/media_type.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/text.h"
#include "rubicon/key.hpp"

namespace rubicon::web::api {

namespace {

constexpr std::string_view kBytes = "application/octet-stream";
constexpr std::size_t kLongest = 127;  // RFC 6838, section 4.2

/// RFC 9110, section 5.6.2
bool is_token(std::string_view text) {
  const auto is_part = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ||
           std::string_view("!#$%&'*+-.^_`|~").find(c) != std::string_view::npos;
  };
  return !text.empty() && std::all_of(text.begin(), text.end(), is_part);
}

}  // namespace

Result<std::string> media_type_of(std::string_view field) {
  std::string type(base::trimmed(field.substr(0, field.find(';'))));
  std::transform(type.begin(), type.end(), type.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 'a' - 'A') : c; });
  const auto slash = type.find('/');
  const bool is_type = slash != type.npos && type.size() <= kLongest &&
                       is_token(std::string_view(type).substr(0, slash)) &&
                       is_token(std::string_view(type).substr(slash + 1));
  if (is_type) return type;
  return fail(ErrorCode::kInvalid,
              fmt::format("Content-Type is {}; expected a media type such as text/plain", model::quoted(field)));
}

SafeType safe_type(std::string_view media_type) {
  constexpr std::array<std::string_view, 9> kShown{"text/plain", "application/json", "image/png",
                                                   "image/jpeg", "image/gif",        "image/webp",
                                                   "image/bmp",  "image/avif",       "application/cbor"};
  const auto type = media_type_of(media_type);
  if (!type) return {std::string(kBytes), false};
  if (std::find(kShown.begin(), kShown.end(), *type) != kShown.end()) return {*type, true};
  // Pictures in a page run no scripts; opened by itself, an SVG picture would.
  if (type->starts_with("image/") || type->starts_with("audio/") || type->starts_with("video/")) return {*type, false};
  return {std::string(kBytes), false};
}

}  // namespace rubicon::web::api
