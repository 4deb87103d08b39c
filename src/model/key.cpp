#include <fmt/format.h>

#include <array>

#include "base/text.h"
#include "rubicon/address.hpp"
#include "rubicon/key.hpp"

namespace rubicon::model {

std::string to_string(const Address& address) {
  auto text = fmt::format("{}", number(address.island));
  if (!address.network.empty()) text += '/' + address.network;
  if (!address.device.empty()) text += '/' + address.device;
  return text;
}

namespace {

constexpr std::array<bool, 256> kPartCharacters = [] {
  std::array<bool, 256> all{};
  for (const char c : std::string_view("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-"))
    all[static_cast<unsigned char>(c)] = true;
  return all;
}();

bool is_part_character(char c) {
  return kPartCharacters[static_cast<unsigned char>(c)];
}

/// Without a reason, which most keys do not need.
bool is_key(std::string_view key) {
  if (key.size() > kMaxKeyLength) return false;
  std::size_t parts = 1;
  char before = '.';
  for (const char c : key) {
    if (c == '.' ? before == '.' : !is_part_character(c)) return false;
    parts += c == '.';
    before = c;
  }
  return before != '.' && parts <= kMaxKeyParts;
}

Result<void> check_size(std::string_view key) {
  if (key.empty()) return fail(ErrorCode::kInvalid, "key is empty");
  if (key.size() > kMaxKeyLength) {
    return fail(ErrorCode::kInvalid, fmt::format("key {} has {} characters, at most {} are allowed", quoted(key),
                                                 key.size(), kMaxKeyLength));
  }
  return {};
}

Result<void> check_part(std::string_view key, std::string_view part) {
  const auto offset = static_cast<std::size_t>(part.data() - key.data());
  if (part.empty()) {
    return fail(ErrorCode::kInvalid, fmt::format("key {}: empty part at position {}", quoted(key), offset));
  }
  for (std::size_t i = 0; i < part.size(); ++i) {
    if (is_part_character(part[i])) continue;
    return fail(ErrorCode::kInvalid, fmt::format("key {}: {} at position {}; parts are [A-Za-z0-9_-]+", quoted(key),
                                                 quoted(base::first_character(part.substr(i))), offset + i));
  }
  return {};
}

Result<std::vector<std::string_view>> bounded_parts(std::string_view key) {
  if (auto size = check_size(key); !size) return fail(size.error());
  auto parts = key_parts(key);
  if (parts.size() > kMaxKeyParts) {
    return fail(ErrorCode::kInvalid,
                fmt::format("key {} has {} parts, at most {} are allowed", quoted(key), parts.size(), kMaxKeyParts));
  }
  return parts;
}

Result<void> check_pattern_key(std::string_view key) {
  const auto parts = bounded_parts(key);
  if (!parts) return fail(parts.error());
  for (std::size_t i = 0; i < parts->size(); ++i) {
    const auto part = (*parts)[i];
    if (part == "*") continue;
    if (part == "**") {
      if (i + 1 == parts->size()) continue;
      return fail(ErrorCode::kInvalid, fmt::format("pattern {}: ** may only be the last part", quoted(key)));
    }
    if (auto ok = check_part(key, part); !ok) return ok;
  }
  return {};
}

}  // namespace

std::vector<std::string_view> key_parts(std::string_view key) {
  std::vector<std::string_view> parts;
  std::size_t begin = 0;
  for (std::size_t dot = key.find('.'); dot != key.npos; dot = key.find('.', begin)) {
    parts.push_back(key.substr(begin, dot - begin));
    begin = dot + 1;
  }
  parts.push_back(key.substr(begin));
  return parts;
}

Result<void> check_key(std::string_view key) {
  if (is_key(key)) return {};
  const auto parts = bounded_parts(key);
  if (!parts) return fail(parts.error());
  for (const auto part : *parts) {
    if (auto ok = check_part(key, part); !ok) return ok;
  }
  return {};
}

std::string to_key_part(std::string_view text, std::size_t limit) {
  std::string part(text.substr(0, limit));
  for (auto& c : part) {
    if (!is_part_character(c)) c = '_';
  }
  return part.empty() ? "_" : part;
}

std::string quoted(std::string_view text) {
  constexpr std::size_t kMaxUtf8 = 4;
  std::string out = "'";
  std::size_t shown = 0;
  for (; !text.empty() && shown < 60; ++shown) {
    const auto character = base::first_character(text.substr(0, kMaxUtf8));
    const bool good = base::printable(character) == character;
    if (good) {
      out += character;
    } else {
      base::append(out, "\\x{:02x}", static_cast<unsigned char>(text.front()));
    }
    text.remove_prefix(good ? character.size() : 1);
  }
  out += text.empty() ? "'" : "...'";
  return out;
}

Result<Pattern> Pattern::parse(std::string_view text) {
  Pattern pattern;
  const auto colon = text.find(':');
  if (colon != text.npos) {
    const auto owner = text.substr(0, colon);
    const auto id = base::parse_number<std::uint32_t>(owner).value_or(0);
    const bool any = owner == "*";
    if (!any && id == 0) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("pattern {}: expected an owner id or * before the colon", quoted(text)));
    }
    if (!any) pattern.owner = OwnerId(id);
    text.remove_prefix(colon + 1);
  }
  if (auto ok = check_pattern_key(text); !ok) return fail(ok.error());
  pattern.key = text;
  return pattern;
}

bool Pattern::matches(OwnerId tuple_owner, std::string_view tuple_key) const {
  if (owner && *owner != tuple_owner) return false;
  std::string_view wanted = key;
  while (true) {
    const auto want_dot = wanted.find('.');
    const auto want = wanted.substr(0, want_dot);
    if (want == "**") return true;
    const auto have_dot = tuple_key.find('.');
    if (want != "*" && want != tuple_key.substr(0, have_dot)) return false;
    if (want_dot == wanted.npos) return have_dot == tuple_key.npos;
    wanted.remove_prefix(want_dot + 1);
    if (have_dot == tuple_key.npos) return wanted == "**";
    tuple_key.remove_prefix(have_dot + 1);
  }
}

bool Pattern::exact() const {
  return key.find('*') == key.npos;
}

std::string to_string(const Pattern& pattern) {
  return pattern.owner ? fmt::format("{}:{}", number(*pattern.owner), pattern.key) : pattern.key;
}

}  // namespace rubicon::model
