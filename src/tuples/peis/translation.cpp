#include "tuples/peis/translation.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "tuples/peis/tuple_wire.h"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

namespace {

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool is_same(std::string_view one, std::string_view other) {
  return std::equal(one.begin(), one.end(), other.begin(), other.end(),
                    [](char a, char b) { return lower(a) == lower(b); });
}

std::string joined(const std::vector<std::string>& parts) {
  std::string key;
  for (const auto& part : parts) {
    if (!key.empty()) key += '.';
    key += part;
  }
  return key;
}

}  // namespace

std::string folded(std::string_view key) {
  std::string out(key);
  std::transform(out.begin(), out.end(), out.begin(), lower);
  return out;
}

bool is_folded(std::string_view key) {
  return std::all_of(key.begin(), key.end(), [](char c) { return lower(c) == c; });
}

Result<void> check_peis_key(std::string_view key) {
  if (key.size() > kMaxPeisKey)
    return fail(ErrorCode::kOutOfRange, fmt::format("key {} has {} characters, PEIS kernels allow {}",
                                                    model::quoted(key), key.size(), kMaxPeisKey));
  const auto parts = static_cast<std::size_t>(std::count(key.begin(), key.end(), '.')) + 1;
  if (parts > kMaxPeisParts)
    return fail(ErrorCode::kOutOfRange,
                fmt::format("key {} has {} parts, PEIS kernels allow {}", model::quoted(key), parts, kMaxPeisParts));
  return {};
}

std::vector<std::string> to_kernel_patterns(std::string_view key) {
  if (key == "**") return {std::string(kEveryKey)};
  std::vector<std::string> patterns;
  std::string next(key);
  const bool open = next.ends_with(".**");
  if (open) next.resize(next.size() - 3);
  for (; check_peis_key(next); next += ".*") {
    patterns.push_back(next);
    if (!open) break;
  }
  return patterns;
}

Result<std::string> from_kernel_pattern(std::string_view key) {
  if (key.empty()) return std::string("**");
  auto pattern = Pattern::parse(key);
  if (!pattern) return fail(pattern.error());
  if (pattern->key.ends_with("**") || pattern->owner)
    return fail(ErrorCode::kInvalid, fmt::format("key {}: not one of a kernel", model::quoted(key)));
  return std::move(pattern->key);
}

bool matches_folded(std::string_view pattern, std::string_view key) {
  while (true) {
    const auto want_dot = pattern.find('.'), have_dot = key.find('.');
    const auto want = pattern.substr(0, want_dot);
    if (want == "**") return true;
    if (want != "*" && !is_same(want, key.substr(0, have_dot))) return false;
    if (want_dot == pattern.npos) return have_dot == key.npos;
    pattern.remove_prefix(want_dot + 1);
    if (have_dot == key.npos) return pattern == "**";
    key.remove_prefix(have_dot + 1);
  }
}

/// `a.**` matches `a` too.
std::string_view literal_begin(std::string_view pattern) {
  const auto begin = pattern.substr(0, pattern.find('*'));
  return begin.ends_with('.') && begin.size() < pattern.size() ? begin.substr(0, begin.size() - 1) : begin;
}

std::string spelled_as(std::string_view pattern, std::string_view key) {
  const auto parts = model::key_parts(key);
  std::vector<std::string> spelled;
  for (const auto part : model::key_parts(pattern)) {
    const bool literal = part != "*" && part != "**";
    spelled.emplace_back(literal ? parts.at(spelled.size()) : part);
  }
  return joined(spelled);
}

namespace {

bool is_utf8_without_nul(std::string_view text) {
  while (!text.empty()) {
    const auto character = base::take_utf8(text);
    if (!character || *character == 0) return false;
  }
  return true;
}

bool is_text(std::string_view media_type) {
  return media_type.starts_with("text/");
}

}  // namespace

WireValue to_wire(std::string_view value, std::string_view media_type) {
  WireValue wire{Encoding::kBinary, std::string(value)};
  if (!is_text(media_type) && !is_utf8_without_nul(value)) return wire;
  wire.encoding = Encoding::kAscii;
  wire.data += '\0';
  return wire;
}

std::string_view from_wire(Encoding encoding, std::string_view data) {
  const bool has_nul = encoding == Encoding::kAscii && data.ends_with('\0');
  return has_nul ? data.substr(0, data.size() - 1) : data;
}

std::string_view from_kernel(Encoding encoding, std::string_view data, std::string_view media_type) {
  if (data == std::string_view("\0", 1)) return {};
  const auto first = data.find('\0');
  const bool others = first != data.npos && first + 1 < data.size();
  return others && !is_text(media_type) ? data : from_wire(encoding, data);
}

std::string appended(Encoding encoding, std::string_view data, std::string_view difference) {
  std::string whole(from_wire(encoding, data));
  whole += difference;
  return whole;
}

OwnerId creator_on_wire(OwnerId creator, OwnerId owner) {
  return creator == OwnerId{} || number(creator) > kMaxId ? owner : creator;
}

std::string_view media_type_on_wire(std::string_view media_type) {
  return media_type.empty() ? "text/plain" : media_type.substr(0, kMaxMediaType);
}

NetworkTuple tuple_on_wire(const TupleView& tuple, const WireValue& value, OwnerId self) {
  NetworkTuple out;
  out.owner = self;
  out.key = tuple.key;
  out.creator = creator_on_wire(tuple.creator, self);
  out.write_time = tuple.write_time;
  out.user_time = tuple.user_time;
  out.expire_time = tuple.expire_time;
  out.encoding = value.encoding;
  out.media_type = media_type_on_wire(tuple.media_type);
  out.data = value.data;
  return out;
}

}  // namespace rubicon::tuples::peis
