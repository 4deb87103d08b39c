#include "tuples/peis/patterns.h"

#include <fmt/format.h>

#include <algorithm>

#include "tuples/peis/tuple_wire.h"

namespace rubicon::tuples::peis {

namespace {

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
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
  if (is_folded(pattern) && is_folded(key)) return Pattern{{}, std::string(pattern)}.matches({}, key);
  return Pattern{{}, folded(pattern)}.matches({}, folded(key));
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

}  // namespace rubicon::tuples::peis
