#include "apps/rubicon/selection.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "apps/rubicon/target.h"
#include "base/glob.h"
#include "model/former_types.h"
#include "model/property_alias.h"

namespace rubicon::cli {

namespace {

bool is_wild_within(std::string_view part) {
  return part != "*" && part != "**" && part.find_first_of("*?") != part.npos;
}

Result<Selection> parse_one(std::string_view text) {
  const auto colon = text.find(':');
  const auto owner = colon == text.npos ? std::string_view() : text.substr(0, colon + 1);
  std::string plain(owner);
  std::vector<std::string> globs;
  bool narrower = false;
  for (const auto part : model::key_parts(text.substr(owner.size()))) {
    const bool wild = is_wild_within(part);
    narrower = narrower || wild;
    plain += (globs.empty() ? "" : ".") + (wild ? std::string("*") : std::string(part));
    globs.emplace_back(wild ? part : "*");
  }
  auto pattern = Pattern::parse(plain);
  if (!pattern) return fail(pattern.error());
  if (!narrower) globs.clear();
  return Selection{std::move(*pattern), std::string(text), std::move(globs)};
}

Result<Selections> short_and_long(std::string_view text, std::string_view last) {
  const auto colon = text.find(':');
  const auto owner = colon == text.npos ? std::string() : std::string(text.substr(0, colon + 1));
  const auto key = model::without_alias(text.substr(owner.size()));
  auto typed = parse_one(owner + key);
  if (!typed) return fail(typed.error());
  Selections all{std::move(*typed)};
  if (key.ends_with("**")) return all;
  if (is_wild_within(key) && key.find('.') == std::string::npos) {  // `temperature*`: points of any device
    auto points = parse_one(fmt::format("{}*.*.*.*.{}.{}", owner, key, last));
    if (!points) return fail(points.error());
    all.push_back(std::move(*points));
    return all;
  }
  const auto longer = long_form({{}, key}, last);
  if (!longer) return all;
  auto parsed = parse_one(owner + longer->key);
  if (!parsed) return fail(parsed.error());
  all.push_back(std::move(*parsed));
  return all;
}

}  // namespace

bool Selection::fits(OwnerId owner, std::string_view key) const {
  if (!pattern.matches(owner, key)) return false;
  const auto parts = model::key_parts(key);
  for (std::size_t i = 0; i < globs.size() && i < parts.size(); ++i) {
    if (!base::glob_matches(globs[i], parts[i])) return false;
  }
  return true;
}

Result<Selections> parse_selections(std::string_view text, std::string_view last) {
  auto all = short_and_long(text, last);
  const auto now = model::current_key(text);
  if (!all || now == text) return all;
  auto of_today = short_and_long(now, last);
  if (!of_today) return of_today;
  std::move(of_today->begin(), of_today->end(), std::back_inserter(*all));
  return all;
}

Result<Selections> parse_selections(const std::vector<std::string>& texts, const std::string& otherwise,
                                    std::string_view last) {
  if (texts.empty()) return parse_selections(otherwise, last);
  Selections all;
  for (const auto& text : texts) {
    auto parsed = parse_selections(text, last);
    if (!parsed) return parsed;
    std::move(parsed->begin(), parsed->end(), std::back_inserter(all));
  }
  return all;
}

bool any_fits(const Selections& selections, OwnerId owner, std::string_view key) {
  return std::any_of(selections.begin(), selections.end(), [&](const Selection& one) { return one.fits(owner, key); });
}

}  // namespace rubicon::cli
