#include "apps/rubicon/target.h"

#include <fmt/format.h>

#include "apps/rubicon/session.h"
#include "apps/rubicon/tuple_text.h"

namespace rubicon::cli {

namespace {

/// Candidates that are named when several fit.
constexpr std::size_t kNamed = 10;

std::vector<Target> present(Session& session, const Pattern& pattern) {
  std::vector<Target> found;
  for (auto& tuple : session.read(pattern)) found.push_back({tuple.owner, std::move(tuple.key)});
  return found;
}

bool is_point_kind(std::string_view part) {
  return part == "sensor" || part == "actuator" || part == "property";
}

}  // namespace

Result<TypedTarget> parse_target(std::string_view text) {
  const auto pattern = Pattern::parse(text);
  if (!pattern) return fail(pattern.error());
  if (!pattern->exact())
    return fail(ErrorCode::kInvalid, fmt::format("{} is a pattern, expected one tuple", model::quoted(text)));
  return TypedTarget{pattern->owner, pattern->key};
}

std::optional<Pattern> long_form(const TypedTarget& typed, std::string_view last) {
  const auto parts = model::key_parts(typed.key);
  if (parts.size() == 2) return Pattern{typed.owner, fmt::format("*.*.{}.*.{}.{}", parts[0], parts[1], last)};
  if (parts.size() == 3)
    return Pattern{typed.owner, fmt::format("*.{}.{}.*.{}.{}", parts[0], parts[1], parts[2], last)};
  if (parts.size() == 5 && is_point_kind(parts[3])) return Pattern{typed.owner, fmt::format("{}.{}", typed.key, last)};
  return std::nullopt;
}

std::vector<Target> resolve(Session& session, const TypedTarget& typed, std::string_view last) {
  auto found = present(session, {typed.owner, typed.key});
  if (!found.empty()) return found;
  const auto longer = long_form(typed, last);
  return longer ? present(session, *longer) : found;
}

Result<std::vector<Pattern>> parse_patterns(std::string_view text, std::string_view last) {
  auto pattern = Pattern::parse(text);
  if (!pattern) return fail(pattern.error());
  std::vector<Pattern> all{std::move(*pattern)};
  if (!all[0].exact()) return all;
  if (auto longer = long_form({all[0].owner, all[0].key}, last)) all.push_back(std::move(*longer));
  return all;
}

Result<std::vector<Pattern>> parse_patterns(const std::vector<std::string>& texts, const std::string& otherwise,
                                            std::string_view last) {
  if (texts.empty()) return parse_patterns(otherwise, last);
  std::vector<Pattern> all;
  for (const auto& text : texts) {
    auto parsed = parse_patterns(text, last);
    if (!parsed) return parsed;
    all.insert(all.end(), parsed->begin(), parsed->end());
  }
  return all;
}

int ambiguous(std::string_view typed, const std::vector<Target>& candidates) {
  std::string names;
  for (std::size_t i = 0; i < candidates.size() && i < kNamed; ++i)
    names += "\n  " + name_of(candidates[i].owner, candidates[i].key);
  if (candidates.size() > kNamed) names += fmt::format("\n  and {} more", candidates.size() - kNamed);
  say(fmt::format("{} may be each of these, say which:{}", model::quoted(typed), names));
  return kUsage;
}

}  // namespace rubicon::cli
