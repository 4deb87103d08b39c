#include "networks/knx/secure/password_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>

namespace rubicon::networks::knx::secure {

namespace {

constexpr std::size_t kLongest = 1024;
/// Editors of Windows may begin a file in UTF-8 with it.
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

/// The first line of the text, if there is no other.
Result<Secret> password_in(std::string_view text, std::string_view where) {
  const auto end = std::min(text.find_first_of("\r\n"), text.size());
  const bool more = text.find_first_not_of("\r\n", end) != text.npos;
  if (end == 0 || more || end > kLongest)
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: expected one line with a password of at most {} bytes", where, kLongest));
  return Secret::of_text(text.substr(0, end));
}

}  // namespace

Result<Secret> read_private_file(transport::Transports& transports, const std::string& path, std::size_t largest,
                                 std::string_view what) {
  auto file = transports.open_file(path);
  if (!file) return fail(file.error());
  if ((*file)->open_to_others())
    return fail(
        ErrorCode::kRefused,
        fmt::format("{}: other users of this machine can read {}; run chmod 600 {} as its owner", path, what, path));
  Secret content(largest + 1);
  std::size_t done = 0;
  while (done < content.size()) {
    const auto count = (*file)->read(content.span().subspan(done));
    if (!count) return fail(count.error());
    if (*count == 0) break;
    done += *count;
  }
  if (done > largest) return fail(ErrorCode::kOutOfRange, fmt::format("{}: has more than {} bytes", path, largest));
  return Secret(content.view().first(done));
}

Result<Secret> read_password_file(transport::Transports& transports, const std::string& path) {
  constexpr auto kLargest = kByteOrderMark.size() + kLongest + 2;  // with a line end
  const auto content = read_private_file(transports, path, kLargest, "this password");
  if (!content) return content.error().code == ErrorCode::kOutOfRange ? password_in({}, path) : fail(content.error());
  auto text = content->text();
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  return password_in(text, path);
}

Result<std::optional<Secret>> find_password(transport::Transports& transports, const std::string& path,
                                            const char* variable) {
  if (!path.empty()) {
    auto password = read_password_file(transports, path);
    if (!password) return fail(password.error());
    return std::optional(std::move(*password));
  }
  const char* value = std::getenv(variable);
  if (value == nullptr || *value == '\0') return std::optional<Secret>();
  auto password = password_in(value, fmt::format("environment variable {}", variable));
  if (!password) return fail(password.error());
  return std::optional(std::move(*password));
}

std::string password_source(const Secret& password, const std::string& path, const char* variable) {
  constexpr std::string_view kBlanks = " \t";
  const auto text = password.text();
  const bool blank =
      !text.empty() && (kBlanks.find(text.front()) != kBlanks.npos || kBlanks.find(text.back()) != kBlanks.npos);
  return fmt::format(" (the password is from {}{})",
                     path.empty() ? fmt::format("the environment variable {}", variable) : path,
                     blank ? ", and begins or ends with a blank" : "");
}

}  // namespace rubicon::networks::knx::secure
