#include "tuples/carry/carry_rules.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/text.h"

namespace rubicon::tuples::carry {

namespace {

constexpr std::string_view kRest = "**", kOne = "*";

/// True also for -5, 3.0 and 07: they are not valid ids, and are refused instead of taken as key patterns.
bool is_number(std::string_view text) {
  return text.find_first_not_of("0123456789.-") == text.npos && text.find_first_of("0123456789") != text.npos;
}

bool ends_with_rest(const std::vector<std::string_view>& parts) {
  return !parts.empty() && parts.back() == kRest;
}

}  // namespace

std::vector<std::string> CarryRules::keys_of(OwnerId id) const {
  return ids.contains(id) ? std::vector<std::string>{std::string(kRest)} : patterns;
}

bool CarryRules::carries(OwnerId id, std::string_view key) const {
  const auto keys = keys_of(id);
  return std::any_of(keys.begin(), keys.end(), [&](const auto& one) { return Pattern{{}, one}.matches(id, key); });
}

Result<void> add_entry(CarryRules& rules, std::string_view text) {
  if (is_number(text)) {
    const auto id = base::parse_number<std::uint32_t>(text).value_or(0);
    if (id == 0 || id > 0x7fff'ffff || text.front() == '0')
      return fail(ErrorCode::kInvalid, fmt::format("is '{}', expected the id of a component, 1 to 2147483647", text));
    if (rules.ids.insert(OwnerId(id)).second) return {};
    return fail(ErrorCode::kDuplicate, fmt::format("'{}' is listed twice", text));
  }
  auto pattern = Pattern::parse(text);
  if (!pattern)
    return fail(ErrorCode::kInvalid, fmt::format("expected the id of a component, or a pattern of keys such as "
                                                 "kitchen.**: {}",
                                                 pattern.error().text));
  if (pattern->owner)
    return fail(ErrorCode::kInvalid, fmt::format("is {}, expected an id or a pattern, not both", model::quoted(text)));
  if (std::find(rules.patterns.begin(), rules.patterns.end(), pattern->key) != rules.patterns.end())
    return fail(ErrorCode::kDuplicate, fmt::format("'{}' is listed twice", text));
  rules.patterns.push_back(std::move(pattern->key));
  return {};
}

std::optional<std::string> common_keys(std::string_view one, std::string_view other) {
  auto a = model::key_parts(one), b = model::key_parts(other);
  const bool open = ends_with_rest(a) && ends_with_rest(b);
  const auto fixed = [](const auto& parts) { return parts.size() - (ends_with_rest(parts) ? 1 : 0); };
  const auto all = std::max(fixed(a), fixed(b));
  if ((!ends_with_rest(a) && fixed(a) < all) || (!ends_with_rest(b) && fixed(b) < all)) return {};
  std::vector<std::string_view> parts;
  for (std::size_t at = 0; at < all; ++at) {
    const auto left = at < fixed(a) ? a[at] : kOne, right = at < fixed(b) ? b[at] : kOne;
    if (left != right && left != kOne && right != kOne) return {};
    parts.push_back(left == kOne ? right : left);
  }
  if (open) parts.push_back(kRest);
  if (parts.size() > model::kMaxKeyParts) return {};
  return fmt::format("{}", fmt::join(parts, "."));
}

}  // namespace rubicon::tuples::carry
