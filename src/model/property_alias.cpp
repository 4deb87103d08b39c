#include "model/property_alias.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rubicon/key.hpp"

namespace rubicon::model {

namespace {

constexpr std::string_view kRate = "rate";
constexpr std::size_t kKindAt = 3;

}  // namespace

std::string without_alias(std::string_view key) {
  if (key.find(kSamplingRate) == key.npos) return std::string(key);
  auto parts = key_parts(key);
  const bool whole = parts.size() > kKindAt + 1 && parts[kKindAt] == "property";
  const bool brief = parts.size() == 2 || parts.size() == 3;
  if (!whole && !brief) return std::string(key);
  auto& property = whole ? parts[kKindAt + 1] : parts.back();
  if (property == kSamplingRate) property = kRate;
  return fmt::format("{}", fmt::join(parts, "."));
}

}  // namespace rubicon::model
