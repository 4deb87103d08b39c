#include "trust/site/passwords.h"

#include <fmt/format.h>
#include <openssl/evp.h>
#include <openssl/rand.h>

#include <array>
#include <optional>

#include "base/text.h"
#include "trust/openssl_handles.h"
#include "trust/private_key.h"
#include "trust/site/user_names.h"

namespace rubicon::trust::site {

namespace {

constexpr int kPasswordRounds = 101;  // what mosquitto_passwd takes
constexpr int kMostPasswordRounds = 10'000'000;
constexpr std::size_t kSaltSize = 12, kHashSize = 64;
constexpr std::string_view kHashForm = "$7$";
constexpr std::size_t kPhraseGroup = 4;

std::string base64(const unsigned char* bytes, std::size_t size) {
  std::string text(4 * ((size + 2) / 3) + 1, '\0');
  const int written = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), bytes, static_cast<int>(size));
  text.resize(static_cast<std::size_t>(std::max(written, 0)));
  return text;
}

std::optional<std::array<unsigned char, kSaltSize>> salt_in(std::string_view text) {
  std::array<unsigned char, kSaltSize> salt{};
  if (text.size() != 4 * kSaltSize / 3) return {};
  const int size =
      EVP_DecodeBlock(salt.data(), reinterpret_cast<const unsigned char*>(text.data()), static_cast<int>(text.size()));
  return size == static_cast<int>(kSaltSize) ? std::optional(salt) : std::nullopt;
}

std::string hash_of(std::string_view password, const std::array<unsigned char, kSaltSize>& salt, int rounds) {
  std::array<unsigned char, kHashSize> hash{};
  if (PKCS5_PBKDF2_HMAC(password.data(), static_cast<int>(password.size()), salt.data(), static_cast<int>(salt.size()),
                        rounds, EVP_sha512(), static_cast<int>(hash.size()), hash.data()) != 1)
    return {};
  return fmt::format("{}{}${}${}", kHashForm, rounds, base64(salt.data(), salt.size()),
                     base64(hash.data(), hash.size()));
}

}  // namespace

Result<std::string> password_hash(std::string_view password) {
  std::array<unsigned char, kSaltSize> salt{};
  if (RAND_bytes(salt.data(), static_cast<int>(salt.size())) != 1) return openssl_failed("make a password");
  auto hash = hash_of(password, salt, kPasswordRounds);
  if (hash.empty()) return openssl_failed("keep a password");
  return hash;
}

bool is_password_of(std::string_view password, std::string_view hash) {
  if (!hash.starts_with(kHashForm)) return false;
  const auto rest = hash.substr(kHashForm.size());
  const auto first = rest.find('$'), second = first == rest.npos ? first : rest.find('$', first + 1);
  if (second == rest.npos) return false;
  const auto rounds = base::parse_number<int>(rest.substr(0, first));
  const auto salt = salt_in(rest.substr(first + 1, second - first - 1));
  return rounds && *rounds > 0 && *rounds <= kMostPasswordRounds && salt && hash_of(password, *salt, *rounds) == hash;
}

SecretText spelled_phrase(std::string_view typed) {
  const auto plain = plain_phrase(typed);
  std::string spelled;
  spelled.reserve(2 * plain.view().size());
  for (std::size_t i = 0; i < plain.view().size(); ++i) {
    if (i > 0 && i % kPhraseGroup == 0) spelled += '-';
    spelled += plain.view()[i];
  }
  return SecretText(std::move(spelled));
}

Result<PasswordLines> parse_passwords(std::string_view text, std::string_view where) {
  PasswordLines lines;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const auto end = text.find('\n');
    const auto line = base::trimmed(text.substr(0, end));
    text.remove_prefix(end == text.npos ? text.size() : end + 1);
    if (line.empty() || line.starts_with('#')) continue;
    const auto colon = line.find(':');
    const auto user = line.substr(0, colon);
    if (auto checked = check_user_name(user); !checked)
      return fail(ErrorCode::kInvalid, fmt::format("{}:{}: {}", where, number, checked.error().text));
    if (colon == line.npos || !line.substr(colon + 1).starts_with('$'))
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}:{}: expected {}:$7$..., as mosquitto_passwd writes it", where, number, user));
    lines[std::string(user)] = line.substr(colon + 1);
  }
  return lines;
}

std::string passwords_text(const PasswordLines& lines) {
  std::string text;
  for (const auto& [user, hash] : lines) text += user + ":" + hash + "\n";
  return text;
}

}  // namespace rubicon::trust::site
