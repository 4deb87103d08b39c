#include "apps/rubicon/target.h"

#include <fmt/format.h>

#include "apps/rubicon/island_option.h"
#include "apps/rubicon/session.h"
#include "apps/rubicon/tuple_text.h"
#include "model/former_types.h"
#include "model/point_keys.h"
#include "model/property_alias.h"

namespace rubicon::cli {

namespace {

/// Candidates that are named when several fit.
constexpr std::size_t kNamed = 10;

std::vector<Target> present(Session& session, const Pattern& pattern) {
  std::vector<Target> found;
  for (auto& tuple : session.read(pattern)) found.push_back({tuple.owner, std::move(tuple.key)});
  return found;
}

}  // namespace

Result<TypedTarget> parse_target(Session& session, std::string_view text) {
  return parse_target(with_island_id(session, text));
}

Result<TypedTarget> parse_target(std::string_view text) {
  if (text.find_first_of("*?") != text.npos) {
    return fail(ErrorCode::kInvalid, fmt::format("{} is a pattern, expected one tuple; `rubicon ls` lists all that fit",
                                                 model::quoted(text)));
  }
  const auto pattern = Pattern::parse(text);
  if (!pattern) return fail(pattern.error());
  return TypedTarget{pattern->owner, model::without_alias(pattern->key)};
}

std::optional<Pattern> long_form(const TypedTarget& typed, std::string_view last) {
  const auto parts = model::key_parts(typed.key);
  const auto point = [&](std::string_view network, std::string_view device, std::string_view id) {
    const auto key = model::IslandKey{"*"}.network(network).device(device).point("*", id);
    return Pattern{typed.owner, fmt::format("{}.{}", key.text, last)};
  };
  if (parts.size() == 2) return point("*", parts[0], parts[1]);
  if (parts.size() == 3) return point(parts[0], parts[1], parts[2]);
  if (parts.size() == 5 && model::parse_kind(parts[3]))
    return Pattern{typed.owner, fmt::format("{}.{}", typed.key, last)};
  return std::nullopt;
}

std::vector<Target> resolve(Session& session, const TypedTarget& typed, std::string_view last) {
  auto found = present(session, {typed.owner, typed.key});
  if (!found.empty()) return found;
  if (const auto longer = long_form(typed, last)) found = present(session, *longer);
  const TypedTarget now{typed.owner, model::current_key(typed.key)};
  return found.empty() && now.key != typed.key ? resolve(session, now, last) : found;
}

int ambiguous(std::string_view typed, const std::vector<Target>& candidates) {
  std::string names;
  for (std::size_t i = 0; i < candidates.size() && i < kNamed; ++i)
    names += "\n  " + name_of(candidates[i].owner, candidates[i].key);
  if (candidates.size() > kNamed) names += fmt::format("\n  and {} more", candidates.size() - kNamed);
  print_error(fmt::format("{} is ambiguous; name one of:{}", model::quoted(typed), names));
  return kUsage;
}

}  // namespace rubicon::cli
