#include "tuples/carry/carry_rules.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/text.h"
#include "model/json_members.h"
#include "rubicon/summary.hpp"

namespace rubicon::tuples::carry {

namespace {

constexpr std::string_view kRest = "**", kOne = "*";

/// True also for -5, 3.0 and 07: they are not valid ids, and are refused instead of taken as key patterns.
bool is_number(std::string_view text) {
  return text.find_first_not_of("0123456789.-") == text.npos && text.find_first_of("0123456789") != text.npos;
}

bool is_named(const std::vector<std::string>& names, std::string_view name) {
  return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

/// FNV-1a, http://www.isthe.com/chongo/tech/comp/fnv: the same in every release.
std::uint64_t mixed(std::uint64_t hash, std::string_view text) {
  if (hash == 0) hash = 0xcbf2'9ce4'8422'2325;
  for (const auto c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100'0000'01b3;
  return (hash ^ 0xff) * 0x100'0000'01b3;
}

bool ends_with_rest(const std::vector<std::string_view>& parts) {
  return !parts.empty() && parts.back() == kRest;
}

}  // namespace

bool CarryRule::covers(Way way) const {
  return is_named(from, way.from) && is_named(to, way.to) && way.from != way.to;
}

bool CarryRules::carries_any_of(OwnerId id, Way way) const {
  return std::any_of(rules.begin(), rules.end(), [&](const CarryRule& rule) {
    return (!rule.patterns.empty() || rule.ids.contains(id)) && rule.covers(way);
  });
}

std::vector<std::string> CarryRules::keys_of(OwnerId id, Way way) const {
  std::vector<std::string> keys;
  for (const auto& rule : rules) {
    if (!rule.covers(way)) continue;
    if (rule.ids.contains(id)) return {std::string(kRest)};
    keys.insert(keys.end(), rule.patterns.begin(), rule.patterns.end());
  }
  return keys;
}

bool CarryRules::carries(OwnerId id, std::string_view key, Way way) const {
  const auto keys = keys_of(id, way);
  return std::any_of(keys.begin(), keys.end(), [&](const auto& one) { return Pattern{{}, one}.matches(id, key); });
}

std::string CarryRules::digest(std::string_view one, std::string_view other) const {
  std::uint64_t all = 0;
  const auto [first, second] = std::minmax(one, other);
  for (const auto way : {Way{first, second}, Way{second, first}}) {
    std::set<std::string> entries;
    for (const auto& rule : rules) {
      if (!rule.covers(way)) continue;
      for (const auto id : rule.ids) entries.insert(fmt::format("{}", number(id)));
      entries.insert(rule.patterns.begin(), rule.patterns.end());
    }
    for (const auto& entry : entries) all = mixed(all, fmt::format("{} {} {}", way.from, way.to, entry));
  }
  return all == 0 ? std::string() : fmt::format("{:016x}", all);
}

Result<void> add_entry(CarryRule& rule, std::string_view text) {
  if (is_number(text)) {
    const auto id = base::parse_number<std::uint32_t>(text).value_or(0);
    if (id == 0 || id > 0x7fff'ffff || text.front() == '0')
      return fail(ErrorCode::kInvalid, fmt::format("is '{}', expected the id of a component, 1 to 2147483647", text));
    if (rule.ids.insert(OwnerId(id)).second) return {};
    return fail(ErrorCode::kDuplicate, fmt::format("'{}' is listed twice", text));
  }
  auto pattern = Pattern::parse(text);
  if (!pattern)
    return fail(ErrorCode::kInvalid, fmt::format("expected the id of a component, or a pattern of keys such as "
                                                 "kitchen.**: {}",
                                                 pattern.error().text));
  if (pattern->owner)
    return fail(ErrorCode::kInvalid, fmt::format("is {}, expected an id or a pattern, not both", model::quoted(text)));
  if (std::find(rule.patterns.begin(), rule.patterns.end(), pattern->key) != rule.patterns.end())
    return fail(ErrorCode::kDuplicate, fmt::format("'{}' is listed twice", text));
  rule.patterns.push_back(std::move(pattern->key));
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

namespace {

constexpr const char* kMember = "carries";
constexpr std::size_t kMaxPairs = 16;

}  // namespace

std::string pair_name(std::string_view one, std::string_view other) {
  const auto [first, second] = std::minmax(one, other);
  return std::string(first) + "-" + std::string(second);
}

std::string with_announcement(std::string summary, const Announcement& carries) {
  auto text = summary.empty() ? std::string("{}") : summary;
  if (carries.empty() || text.back() != '}') return summary;
  text.pop_back();
  if (text != "{") text += ',';
  text += '"' + std::string(kMember) + "\":" + model::dump(nlohmann::json(carries)) + '}';
  return text.size() <= kMaxSummary ? text : summary;
}

Announcement announcement_of(std::string_view summary) {
  Announcement all;
  if (summary.find(kMember) == summary.npos) return all;
  const auto object = model::object_of(summary);
  const auto found = object.find(kMember);
  if (found == object.end() || !found->is_object()) return all;
  for (const auto& [pair, digest] : found->items()) {
    if (digest.is_string() && all.size() < kMaxPairs) all.emplace(pair, digest.get<std::string>());
  }
  return all;
}

}  // namespace rubicon::tuples::carry
