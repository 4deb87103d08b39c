#include "web/access/token_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/rand.h>
#include <openssl/sha.h>

#include <algorithm>
#include <array>
#include <utility>

#include "base/assert.h"
#include "base/own_file.h"
#include "base/text.h"
#include "transport/transports.h"

namespace rubicon::web::access {

Digest sha256(std::string_view bytes) {
  Digest digest{};
  ::SHA256(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(), digest.data());
  return digest;
}

bool same(const Digest& a, const Digest& b) {
  return ::CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

std::string hex(const std::uint8_t* bytes, std::size_t size) {
  std::string text;
  for (std::size_t i = 0; i < size; ++i) text += fmt::format("{:02x}", bytes[i]);
  return text;
}

std::string random_secret() {
  std::array<std::uint8_t, 16> bytes{};
  RUBICON_ASSERT(::RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) == 1);
  return hex(bytes.data(), bytes.size());
}

namespace {

constexpr std::size_t kMaxByteCount = std::size_t{1} << 20;
constexpr std::size_t kMaxNameText = 64;
constexpr std::size_t kMaxRoleCount = 16;

constexpr std::array<std::pair<std::string_view, Role>, 3> kRoles{
    {{"view", Role::kView}, {"command", Role::kCommand}, {"admin", Role::kAdmin}}};

bool is_name(std::string_view text) {
  return !text.empty() && text.size() <= kMaxNameText && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           c == '.';
  });
}

/// In rules these words mean others than one member (docs/rights.md): callers are judged by the name of their token.
bool means_others(std::string_view word) {
  static constexpr std::array<std::string_view, 4> kWords{"everybody", "peis", "lan", "all"};
  return std::find(kWords.begin(), kWords.end(), word) != kWords.end();
}

Result<void> check_name(std::string_view name) {
  if (!is_name(name)) return fail(ErrorCode::kInvalid, "expected a name of [A-Za-z0-9._-], at most 64 characters");
  if (!means_others(name)) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("'{}' is not a name of a token: it means something else in rights, expected another", name));
}

std::optional<Digest> parse_digest(std::string_view text) {
  Digest digest{};
  if (text.size() != 2 * digest.size()) return std::nullopt;
  for (auto& byte : digest) {
    const auto read = base::parse_hex_number<std::uint8_t>(text.substr(0, 2));
    if (!read) return std::nullopt;
    byte = *read;
    text.remove_prefix(2);
  }
  return digest;
}

/// What follows the first comma; nullopt: one of them is not a name, or there are too many.
std::optional<std::vector<std::string>> more_roles(std::string_view text) {
  std::vector<std::string> roles;
  for (auto comma = text.find(','); comma != text.npos; comma = text.find(',')) {
    text.remove_prefix(comma + 1);
    const auto role = base::trimmed(text.substr(0, text.find(',')));
    if (!is_name(role) || means_others(role) || roles.size() >= kMaxRoleCount) return std::nullopt;
    roles.emplace_back(role);
  }
  return roles;
}

Result<Token> parse_line(std::string_view line) {
  constexpr auto kExpected =
      "expected name:role:hash, the role view, command or admin (and names of roles behind it: `view,panel`; not "
      "`everybody`, `peis` or `all`), the hash "
      "64 hexadecimal digits";
  const auto first = line.find(':');
  const auto second = first == line.npos ? line.npos : line.find(':', first + 1);
  if (second == line.npos) return fail(ErrorCode::kInvalid, kExpected);
  const auto name = base::trimmed(line.substr(0, first));
  const auto role_text = line.substr(first + 1, second - first - 1);
  const auto role = parse_role(base::trimmed(role_text.substr(0, role_text.find(','))));
  const auto hash = parse_digest(base::trimmed(line.substr(second + 1)));
  if (auto good = check_name(name); !good) return fail(good.error());
  const auto roles = more_roles(role_text);
  if (!role || !hash || !roles) return fail(ErrorCode::kInvalid, kExpected);
  return Token{std::string(name), *role, *hash, *roles};
}

}  // namespace

std::string_view to_string(Role role) {
  const auto found = std::find_if(kRoles.begin(), kRoles.end(), [role](const auto& one) { return one.second == role; });
  return found == kRoles.end() ? "none" : found->first;
}

std::optional<Role> parse_role(std::string_view word) {
  const auto found = std::find_if(kRoles.begin(), kRoles.end(), [word](const auto& one) { return one.first == word; });
  if (found == kRoles.end()) return std::nullopt;
  return found->second;
}

Result<std::vector<Token>> parse_tokens(std::string_view text) {
  std::vector<Token> tokens;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto line = base::trimmed(text.substr(0, std::min(end, text.find('#'))));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty()) continue;
    auto token = parse_line(line);
    if (!token) return fail(token.error().code, fmt::format("line {}: {}", number, token.error().text));
    for (const auto& other : tokens) {
      if (other.name == token->name)
        return fail(ErrorCode::kDuplicate, fmt::format("line {}: '{}' has a token already", number, other.name));
    }
    tokens.push_back(std::move(*token));
  }
  return tokens;
}

namespace {

Result<std::vector<Token>> parse_file(std::string_view text, const std::string& path) {
  auto tokens = parse_tokens(text);
  if (!tokens) return fail(tokens.error().code, fmt::format("{}: {}", path, tokens.error().text));
  return tokens;
}

}  // namespace

Result<std::vector<Token>> read_tokens(transport::Transports& transports, const std::string& path) {
  const auto text = transport::read_text(transports, path, kMaxByteCount);
  if (!text) return fail(text.error());
  return parse_file(*text, path);
}

std::vector<std::string> names_of(const std::vector<Token>& tokens) {
  std::vector<std::string> names;
  for (const auto& token : tokens) {
    names.push_back(token.name);
    names.emplace_back(to_string(token.role));
    names.insert(names.end(), token.roles.begin(), token.roles.end());
  }
  return names;
}

Result<std::string> add_token(transport::Transports& transports, const std::string& path, const std::string& name,
                              Role role) {
  if (auto good = check_name(name); !good) return fail(good.error());
  auto file = base::OwnFile::open(path, O_WRONLY | O_APPEND);
  if (!file) return fail(file.error());
  const auto text = transport::read_text(transports, path, kMaxByteCount);
  if (!text) return fail(text.error());
  const auto known = parse_file(*text, path);
  if (!known) return fail(known.error());
  if (std::any_of(known->begin(), known->end(), [&](const auto& token) { return token.name == name; }))
    return fail(ErrorCode::kDuplicate, fmt::format("{}: '{}' has a token already; remove its line first", path, name));
  auto token = random_secret();
  const auto hash = sha256(token);
  const std::string_view before = text->empty() || text->ends_with('\n') ? "" : "\n";
  const auto line = fmt::format("{}{}:{}:{}\n", before, name, to_string(role), hex(hash.data(), hash.size()));
  if (auto written = file->write(line, path); !written) return fail(written.error());
  return token;
}

}  // namespace rubicon::web::access
