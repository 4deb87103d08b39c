#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/base64.h"
#include "base/printable.h"
#include "networks/knx/keyring/keyring.h"

namespace rubicon::networks::knx::keyring {

namespace {

constexpr std::string_view kSalt = "1.keyring.ets.knx.org";
/// ETS 5.7 pads to multiples of 32, other writers to multiples of 16.
constexpr std::size_t kRandomBytes = 8, kMaxPadding = 32;

/// Length without the padding: n bytes of value n. 0 = wrong padding, or nothing but that.
std::size_t unpadded(ByteView bytes) {
  if (bytes.empty()) return 0;
  const std::size_t padding = bytes.back();
  if (padding < 1 || padding > kMaxPadding || padding >= bytes.size()) return 0;
  const auto tail = bytes.last(padding);
  const bool good = std::all_of(tail.begin(), tail.end(), [&](auto byte) { return byte == padding; });
  return good ? bytes.size() - padding : 0;
}

}  // namespace

Result<Cipher> Cipher::make(const secure::Secret& password, std::string_view created) {
  auto key = secure::key_of_password(password.view(), kSalt);
  if (!key) return fail(key.error());
  return of_key(std::move(*key), created);
}

Result<Cipher> Cipher::of_key(secure::Key key, std::string_view created) {
  const auto digest = secure::sha256(base::as_bytes(created));
  if (!digest) return fail(digest.error());
  secure::Block start{};
  std::copy_n(digest->begin(), start.size(), start.begin());
  return Cipher(std::move(key), start);
}

Result<secure::Key> Cipher::key(ByteView encrypted) const {
  const auto content = secure::decrypt_cbc(key_, start_, encrypted);
  if (!content) return fail(content.error());
  return secure::Key::from(content->view());
}

std::size_t Cipher::padding(ByteView encrypted) const {
  const auto content = secure::decrypt_cbc(key_, start_, encrypted);
  if (!content) return 0;
  const auto size = unpadded(content->view());
  return size == 0 ? 0 : content->view().size() - size;
}

Result<secure::Secret> Cipher::password(ByteView encrypted) const {
  const auto content = secure::decrypt_cbc(key_, start_, encrypted);
  if (!content) return fail(content.error());
  const auto size = unpadded(content->view());
  if (size < kRandomBytes) return fail(ErrorCode::kInvalid, "a password does not decrypt");
  const auto text = content->view().first(size).subspan(kRandomBytes);
  if (!base::is_utf8(base::as_text(text))) return fail(ErrorCode::kInvalid, "a password does not decrypt");
  return secure::Secret(text);
}

Result<secure::Block> Cipher::sign(ByteView signed_bytes) const {
  auto key_text = base::to_base64(base::as_text(key_.view()));
  Bytes all(signed_bytes.begin(), signed_bytes.end());
  all.reserve(all.size() + 1 + key_text.size());  // no copy with the key is left behind
  all.push_back(static_cast<std::uint8_t>(key_text.size()));
  all.insert(all.end(), key_text.begin(), key_text.end());
  const auto digest = secure::sha256(all);
  secure::wipe(all);
  secure::wipe(key_text);
  if (!digest) return fail(digest.error());
  secure::Block out{};
  std::copy_n(digest->begin(), out.size(), out.begin());
  return out;
}

Result<bool> Cipher::signed_by_this(const KeyringFile& file) const {
  const auto expected = sign(file.signed_bytes);
  if (!expected) return fail(expected.error());
  return secure::equal(*expected, file.signature);
}

}  // namespace rubicon::networks::knx::keyring
