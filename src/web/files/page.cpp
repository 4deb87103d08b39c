#include "web/files/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include "base/text.h"
#include "web/access/token_file.h"
#include "web/exchange.h"

namespace rubicon::web::files {

namespace {

constexpr std::string_view kIndex = "index.html";
/// Digits of a hash in the name of a file whose content never changes: `app-1f2e3d4c.js`.
constexpr std::size_t kHashDigits = 8;

template <class Take>
void for_each_item(std::string_view list, Take take) {
  while (!list.empty()) {
    const auto end = std::min(list.find(','), list.size());
    take(base::trimmed(list.substr(0, end)));
    list.remove_prefix(std::min(end + 1, list.size()));
  }
}

/// RFC 9110, section 12.5.3: without the field every coding is acceptable.
bool takes_gzip(const Request& request) {
  const auto has_field = [](const auto& field) { return field.first == "accept-encoding"; };
  if (std::none_of(request.headers.begin(), request.headers.end(), has_field)) return true;
  bool takes = false;
  for_each_item(request.header("accept-encoding"), [&](std::string_view item) {
    const auto name = base::trimmed(item.substr(0, item.find(';')));
    const auto weight = item.find("q=");
    const bool none = weight != item.npos && item.substr(weight + 2).find_first_not_of("0. ") == item.npos;
    if (name == "gzip" || name == "*") takes = !none;
  });
  return takes;
}

bool client_has(const Request& request, std::string_view tag) {
  bool has = false;
  for_each_item(request.header("if-none-match"), [&](std::string_view item) {
    if (item.starts_with("W/")) item.remove_prefix(2);
    has = has || item == "*" || item == tag;
  });
  return has;
}

bool has_hash_in_name(std::string_view name) {
  const auto dot = name.rfind('.');
  const auto dash = dot == name.npos ? name.npos : name.rfind('-', dot);
  if (dash == name.npos || dot - dash - 1 < kHashDigits) return false;
  return std::all_of(name.begin() + static_cast<std::ptrdiff_t>(dash) + 1,
                     name.begin() + static_cast<std::ptrdiff_t>(dot),
                     [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); });
}

}  // namespace

Response answer(const Request& request, const File& file) {
  if (file.gzip && !takes_gzip(request))
    return error_response(406, ErrorCode::kUnsupported, "this file is sent as gzip only (curl --compressed)");
  const auto tag = fmt::format("\"{}\"", file.hash);
  const bool forever = has_hash_in_name(file.name);
  Response response;
  response.headers = {{"ETag", tag},
                      {"Vary", "Accept-Encoding"},
                      {"Cache-Control", forever ? "public, max-age=31536000, immutable" : "no-cache"}};
  if (client_has(request, tag)) {
    response.status = 304;
    return response;
  }
  if (file.gzip) response.headers.emplace_back("Content-Encoding", "gzip");
  response.content_type = media_type(file.name);
  response.body = file.bytes;
  return response;
}

std::string name_in(std::string_view path) {
  if (path == "/") return std::string(kIndex);
  const auto name = path.substr(1);
  const bool plain = std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' || c == '_' ||
           c == '.' || c == '/';
  });
  if (!plain || name.starts_with('.') || name.find("/.") != name.npos || name.find("//") != name.npos) return {};
  return std::string(name);
}

std::string_view media_type(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 11> kTypes{
      {{".html", "text/html; charset=utf-8"},
       {".js", "text/javascript; charset=utf-8"},
       {".css", "text/css; charset=utf-8"},
       {".json", "application/json"},
       {".map", "application/json"},
       {".svg", "image/svg+xml"},
       {".png", "image/png"},
       {".ico", "image/x-icon"},
       {".woff2", "font/woff2"},
       {".webmanifest", "application/manifest+json"},
       {".txt", "text/plain; charset=utf-8"}}};
  for (const auto& [end, type] : kTypes) {
    if (name.ends_with(end)) return type;
  }
  return "application/octet-stream";
}

std::optional<Response> EmbeddedPage::find(const Request& request) const {
  const auto name = name_in(request.path);
  const auto found = std::find_if(files_.begin(), files_.end(), [&](const auto& file) { return file.name == name; });
  if (found == files_.end()) return std::nullopt;
  return answer(request, *found);
}

namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxFileSize = std::uintmax_t{16} << 20;

/// Nothing outside of the folder, where symbolic links may lead.
std::optional<std::string> read_below(const fs::path& folder, const std::string& name) {
  std::error_code error;
  const auto root = fs::canonical(folder, error);
  if (error) return std::nullopt;
  const auto path = fs::canonical(root / name, error);
  if (error || !path.string().starts_with(root.string() + "/")) return std::nullopt;
  if (!fs::is_regular_file(path, error) || fs::file_size(path, error) > kMaxFileSize || error) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) return std::nullopt;
  return std::move(text).str();
}

}  // namespace

std::optional<Response> FolderPage::find(const Request& request) const {
  const auto name = name_in(request.path);
  const auto bytes = name.empty() ? std::nullopt : read_below(folder_, name);
  if (!bytes) return std::nullopt;
  const auto digest = access::sha256(*bytes);
  const auto hash = access::hex(digest.data(), digest.size());
  return answer(request, {.name = name, .bytes = *bytes, .hash = hash});
}

}  // namespace rubicon::web::files
