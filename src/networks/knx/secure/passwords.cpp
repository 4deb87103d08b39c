#include "networks/knx/secure/passwords.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "networks/knx/secure/crypto.h"

namespace rubicon::networks::knx::secure {

namespace {

// knx.md, section 10.1 (KNX 3/8/9).
constexpr std::string_view kUserSalt = "user-password.1.secure.ip.knx.org";
constexpr std::string_view kDeviceSalt = "device-authentication-code.1.secure.ip.knx.org";
constexpr std::string_view kProjectSalt = "21.project.ets.knx.org";  // knx.md, section 13.4
constexpr std::size_t kArchiveSecret = 32;
constexpr char32_t kFirstPrintable = 0x20, kLastPrintable = 0x7e, kLastLatin1 = 0xff;

/// The characters of a password as one byte each, and with `?` for each byte of UTF-8; the rest of each is unused.
struct Encoded {
  Secret latin1, replaced, replaced_bytewise;
  std::size_t size = 0, bytes = 0;
  bool is_latin1 = true, is_ascii = true;

  ByteView latin1_bytes() const { return latin1.view().first(size); }
  ByteView replaced_bytes() const { return replaced.view().first(size); }
  ByteView bytewise_bytes() const { return replaced_bytewise.view().first(bytes); }
};

Result<Encoded> encode(std::string_view rest) {
  Encoded out{Secret(rest.size()), Secret(rest.size()), Secret(rest.size())};
  while (!rest.empty()) {
    const auto before = rest.size();
    const auto character = base::take_utf8(rest);
    if (!character) return fail(ErrorCode::kInvalid, "the password is not UTF-8");
    const bool printable = *character >= kFirstPrintable && *character <= kLastPrintable;
    out.is_ascii = out.is_ascii && printable;
    out.is_latin1 = out.is_latin1 && *character <= kLastLatin1;
    out.latin1.span()[out.size] = static_cast<std::uint8_t>(*character & 0xffU);
    out.replaced.span()[out.size] = printable ? static_cast<std::uint8_t>(*character) : std::uint8_t{'?'};
    ++out.size;
    for (auto left = before - rest.size(); left > 0; --left, ++out.bytes)
      out.replaced_bytewise.span()[out.bytes] = printable ? static_cast<std::uint8_t>(*character) : std::uint8_t{'?'};
  }
  return out;
}

Result<PasswordKey> keys_of(const Secret& password, std::string_view salt) {
  const auto encoded = encode(password.text());
  if (!encoded) return fail(encoded.error());
  std::vector<ByteView> forms;
  if (encoded->is_latin1) forms.push_back(encoded->latin1_bytes());
  if (!encoded->is_ascii) forms.push_back(encoded->replaced_bytes());
  if (encoded->bytes != encoded->size) forms.push_back(encoded->bytewise_bytes());
  std::vector<Key> keys;
  for (const auto& form : forms) {
    auto key = key_of_password(form, salt);
    if (!key) return fail(key.error());
    keys.push_back(std::move(*key));
  }
  return PasswordKey{keys.front(), {keys.begin() + 1, keys.end()}};
}

/// UTF-16, low byte first. Bytes behind `size` are unused.
struct Utf16 {
  Secret bytes;
  std::size_t size = 0;

  void add(char32_t unit) {
    bytes.span()[size++] = static_cast<std::uint8_t>(unit & 0xffU);
    bytes.span()[size++] = static_cast<std::uint8_t>(unit >> 8U & 0xffU);
  }
};

Result<Utf16> utf16_of(std::string_view rest) {
  Utf16 out{Secret(rest.size() * 2)};
  while (!rest.empty()) {
    const auto character = base::take_utf8(rest);
    if (!character) return fail(ErrorCode::kInvalid, "the password is not UTF-8");
    if (*character < 0x10000) {
      out.add(*character);
    } else {
      out.add(0xd800 + ((*character - 0x10000) >> 10U));
      out.add(0xdc00 + ((*character - 0x10000) & 0x3ffU));
    }
  }
  return out;
}

}  // namespace

Result<PasswordKey> user_key(const Secret& password) {
  return keys_of(password, kUserSalt);
}

Result<PasswordKey> device_code(const Secret& password) {
  return keys_of(password, kDeviceSalt);
}

Result<Secret> archive_password(const Secret& password) {
  const auto encoded = utf16_of(password.text());
  if (!encoded) return fail(encoded.error());
  const auto secret = secret_of_password(encoded->bytes.view().first(encoded->size), kProjectSalt, kArchiveSecret);
  if (!secret) return fail(secret.error());
  return base64_of(secret->view());
}

namespace {

constexpr std::size_t kMaxLength = 1024;
/// Editors of Windows may begin a file in UTF-8 with it.
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

/// The first line of the text, if there is no other.
Result<Secret> password_in(std::string_view text, std::string_view where) {
  const auto end = std::min(text.find_first_of("\r\n"), text.size());
  const bool more = text.find_first_not_of("\r\n", end) != text.npos;
  if (end == 0 || more || end > kMaxLength)
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: expected one line with a password of at most {} bytes", where, kMaxLength));
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
  constexpr auto kMaxSize = kByteOrderMark.size() + kMaxLength + 2;  // with a line end
  const auto content = read_private_file(transports, path, kMaxSize, "this password");
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
