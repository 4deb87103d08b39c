#include "apps/rubicon/targets/selection.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "apps/rubicon/output/output.h"
#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/session.h"
#include "apps/rubicon/targets/options.h"
#include "apps/rubicon/targets/suggestions.h"
#include "base/compare_text.h"
#include "client/points.h"
#include "model/point_keys.h"
#include "model/type_names.h"

namespace rubicon::cli {

namespace {

bool has_wildcard(std::string_view text) {
  return text.find_first_of("*?") != text.npos;
}

}  // namespace

Result<TypedTarget> parse_target(Session& session, std::string_view text) {
  return parse_target(with_island_id(session, text));
}

Result<std::vector<Target>> targets_called(Session& session, std::string_view text, std::string_view last) {
  if (has_wildcard(text)) return fail(parse_target(text).error());
  Result<client::Findings> found{client::Findings()};
  client::TargetSearch search(
      islands_for(session, text), std::string(text), std::string(last),
      [&session](const Pattern& pattern, const client::TuplesCall& call) { call(session.read(pattern)); },
      [&found](Result<client::Findings> findings) { found = std::move(findings); });
  search.start();
  if (!found) return fail(found.error());
  return std::move(found->targets);
}

int ambiguous(std::string_view typed, const std::vector<Target>& candidates) {
  print_error(
      fmt::format("{} is ambiguous; name one of:\n  {}", model::quoted(typed), client::listed(candidates, "\n  ")));
  return kUsage;
}

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

namespace {

/// A key that may be a name as well: of a device without a wildcard, or of a point.
bool may_be_name(std::string_view text) {
  return !has_wildcard(text.substr(0, text.rfind('.'))) && !text.ends_with(".**");
}

bool is_present(Session& session, const Selections& selections) {
  return std::any_of(selections.begin(), selections.end(), [&](const Selection& one) {
    const auto tuples = session.read(one.pattern);
    return std::any_of(tuples.begin(), tuples.end(),
                       [&](const auto& tuple) { return one.fits(tuple.owner, tuple.key); });
  });
}

/// kNotFound: nothing is called so, and it is no key.
Result<Selections> one_called(Session& session, const std::string& text, std::string_view last) {
  auto parsed = parse_selections(with_island_id(session, text), last);
  if (parsed ? !may_be_name(text) || is_present(session, *parsed) : !client::is_like_name(text)) return parsed;
  Selections named;
  for (const auto& point : client::points_called(known_names(session), text, client::Among::kAll)) {
    auto one = parse_one(fmt::format("{}.{}", to_string(point), last));
    if (one) named.push_back(std::move(*one));
  }
  if (!named.empty()) return named;
  if (parsed) return parsed;
  return fail(ErrorCode::kNotFound, fmt::format("nothing is called {}", model::quoted(text)));
}

}  // namespace

int selections_called(Session& session, const std::vector<std::string>& texts, std::string_view last,
                      Selections& selections) {
  for (const auto& text : texts) {
    auto parsed = one_called(session, text, last);
    if (!parsed && parsed.error().code == ErrorCode::kNotFound)
      return session.not_found(parsed.error().text, suggest_tuple(session, text, last));
    if (!parsed) {
      print_error(parsed.error().text);
      return kUsage;
    }
    std::move(parsed->begin(), parsed->end(), std::back_inserter(selections));
  }
  return kGood;
}

bool any_fits(const Selections& selections, OwnerId owner, std::string_view key) {
  return std::any_of(selections.begin(), selections.end(), [&](const Selection& one) { return one.fits(owner, key); });
}

namespace {

bool wakes(const client::Device& device, const Selections& selections) {
  return std::any_of(device.sensors.begin(), device.sensors.end(), [&](const std::string& sensor) {
    const auto key = model::DeviceKey{device.key()}.point(Kind::kSensor, sensor).value();
    return any_fits(selections, device.island, key);
  });
}

}  // namespace

std::size_t count_woken(const std::vector<client::Device>& devices, const Selections& selections) {
  return static_cast<std::size_t>(std::count_if(
      devices.begin(), devices.end(), [&](const client::Device& device) { return wakes(device, selections); }));
}

void warn_if_many_wake(Client& client, const Selections& selections) {
  client.read({std::nullopt, model::IslandKey{"*"}.network("*").device("*").description()},
              [selections](const std::vector<client::Tuple>& tuples) {
                std::vector<client::Device> devices;
                for (const auto& tuple : tuples) {
                  if (auto device = client::device_from(tuple.owner, tuple.key, tuple.value))
                    devices.push_back(std::move(*device));
                }
                if (const auto count = count_woken(devices, selections); count > kManyDevices)
                  print_error(fmt::format("this wakes the sensors of {} devices; --passive wakes none", count));
              });
}

void Wakers::wake(OwnerId owner, std::string_view key) {
  const std::pair name(owner, std::string(key));
  if (handles_.contains(name)) return;
  if (handles_.size() < most_) {
    handles_.emplace(name, subscribe_({owner, name.second}));
  } else if (!std::exchange(full_, true)) {
    print_error(fmt::format("more than {} tuples match: the others are shown, but not woken", most_));
  }
}

void Wakers::forget(OwnerId owner, std::string_view key) {
  handles_.erase({owner, std::string(key)});
}

}  // namespace rubicon::cli
