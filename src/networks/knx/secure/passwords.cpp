#include "networks/knx/secure/passwords.h"

#include <utility>

#include "base/utf8.h"
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

}  // namespace rubicon::networks::knx::secure
