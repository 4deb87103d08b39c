#include "client/target_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "base/compare_text.h"
#include "base/text.h"
#include "client/points.h"
#include "model/json_members.h"
#include "model/point_keys.h"
#include "model/type_names.h"
#include "rubicon/summary.hpp"

namespace rubicon::client {

namespace {

/// Candidates that are named when several fit.
constexpr std::size_t kNamed = 10;
/// Properties that are read to see which can be set; so many names are ambiguous in any case.
constexpr std::size_t kMaxRead = 64;
/// Parts of the key of a point.
constexpr std::size_t kPartsOfAPoint = 5;

bool has_wildcard(std::string_view text) {
  return text.find_first_of("*?") != text.npos;
}

}  // namespace

Result<TypedTarget> parse_target(std::string_view text) {
  if (has_wildcard(text)) {
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
  if (parts.size() == kPartsOfAPoint && model::parse_kind(parts[3]))
    return Pattern{typed.owner, fmt::format("{}.{}", typed.key, last)};
  return std::nullopt;
}

std::string with_island_id(const std::vector<IslandName>& islands, std::string_view text) {
  const auto of = take_islands(islands, text);
  return of.islands.size() == 1 ? fmt::format("{}:{}", number(of.islands.front()), of.rest) : std::string(text);
}

std::vector<IslandName> islands_in(const TupleSpace& space) {
  std::vector<IslandName> found;
  auto components = space.peers();
  components.push_back(space.self());
  for (const auto id : components) {
    if (!model::is_island(id)) continue;
    const auto about = model::summary_from_json(space.summary(id)).value_or(Summary{});
    if (model::is_island(id, about)) found.push_back({id, about.name, about.prefix});
  }
  return found;
}

namespace {

/// `Living room.*`
bool means_all_points(std::string_view text) {
  return text.ends_with(".*") && !has_wildcard(text.substr(0, text.size() - 1)) &&
         is_like_name(text.substr(0, text.size() - 2));
}

/// Whether a key of an island that is present may be short for another one.
bool may_be_short(const TupleSpace& space, OwnerId owner, std::string_view key) {
  if (space.get(owner, key)) return false;
  const auto parts = model::key_parts(key);
  if (parts.size() == kPartsOfAPoint) return model::parse_kind(parts[3]).has_value();
  if (!model::is_island(owner) || (parts.size() != 2 && parts.size() != 3)) return false;
  if (parts.front() == "RUBICON_GATEWAY") return false;  // messages: rights and audit know them by the whole key
  const auto islands = islands_in(space);
  const auto island = std::find_if(islands.begin(), islands.end(), [&](const auto& one) { return one.id == owner; });
  return island != islands.end() && parts.front() != island->prefix;
}

/// What has a number and a key is no name, even if the number is none of an owner. Only islands have names.
bool can_be_name(std::string_view text) {
  constexpr std::string_view kAny = "*:";
  if (has_wildcard(text.starts_with(kAny) ? text.substr(kAny.size()) : text) || !is_like_name(text)) return false;
  const auto colon = text.find(':');
  if (colon == text.npos) return true;
  const auto rest = text.substr(colon + 1);
  const auto number = base::parse_number<std::uint32_t>(text.substr(0, colon));
  if (rest.empty() || (number && !model::is_island(OwnerId(*number)))) return false;
  return !base::parse_number<std::uint64_t>(text.substr(0, colon)) || Pattern::parse(text) || !Pattern::parse(rest);
}

}  // namespace

bool is_name(const TupleSpace& space, std::string_view text) {
  if (!can_be_name(text)) return false;
  const auto tuple = Pattern::parse(text);
  return !tuple || !tuple->owner || may_be_short(space, *tuple->owner, tuple->key);
}

bool is_name_among_patterns(const TupleSpace& space, std::string_view text) {
  const auto pattern = Pattern::parse(text);
  if (!pattern && means_all_points(text)) return true;
  if (!can_be_name(text)) return false;
  if (!pattern) return true;
  if (pattern->owner) return may_be_short(space, *pattern->owner, pattern->key);
  const auto parts = model::key_parts(pattern->key);
  return !text.starts_with('*') &&
         (parts.size() <= 3 || (parts.size() == kPartsOfAPoint && model::parse_kind(parts[3])));
}

std::string listed(const std::vector<Target>& targets, std::string_view separator) {
  std::string text;
  const auto shown = std::min(targets.size(), kNamed);
  for (std::size_t i = 0; i < shown; ++i) text += fmt::format("{}{}", i == 0 ? "" : separator, to_string(targets[i]));
  if (targets.size() > shown) text += fmt::format("{}and {} more", separator, targets.size() - shown);
  return text;
}

Result<Target> the_one(const Findings& findings, std::string_view text) {
  const auto name = model::quoted(text);
  if (findings.targets.size() == 1) return findings.targets.front();
  if (findings.targets.size() > 1)
    return fail(ErrorCode::kInvalid,
                fmt::format("{} is ambiguous; name one of {}", name, listed(findings.targets, ", ")));
  if (findings.is_read_only) return fail(ErrorCode::kNotFound, fmt::format("{} can only be read", name));
  std::string near;
  for (const auto& one : findings.near)
    near += fmt::format("{}{}", near.empty() ? "; did you mean " : " or ", model::quoted(one));
  return fail(ErrorCode::kNotFound, fmt::format("nothing is called {}{}{}", name, near, near.empty() ? "" : "?"));
}

std::vector<Pattern> name_patterns() {
  return {{std::nullopt, model::IslandKey{"*"}.network("*").device("*").description()}, {std::nullopt, "*.overview"}};
}

void add_names(const std::vector<Tuple>& tuples, KnownNames& names) {
  for (const auto& tuple : tuples) {
    if (tuple.key.ends_with(".overview")) {
      add_point_names(tuple.owner, tuple.key, tuple.value, names);
    } else if (auto device = device_from(tuple.owner, tuple.key, tuple.value)) {
      names.devices.push_back(std::move(*device));
    }
  }
}

TargetSearch::TargetSearch(std::vector<IslandName> islands, std::string text, std::string last, Read read, Call call)
    : text_(std::move(text)), last_(std::move(last)), read_(std::move(read)), call_(std::move(call)) {
  names_.islands = std::move(islands);
}

/// Keys under the names that types have today are tried, too.
void TargetSearch::start() {
  const auto typed = parse_target(with_island_id(names_.islands, text_));
  if (!typed && means_all_points(text_)) return by_name();
  if (!typed && (has_wildcard(text_) || !is_like_name(text_))) return end(fail(typed.error()));
  if (typed) {
    for (const auto& key : {typed->key, model::current_key(typed->key)}) {
      if (!keys_.empty() && key == typed->key) continue;
      keys_.push_back({typed->owner, key});
      if (auto longer = long_form({typed->owner, key}, last_)) keys_.push_back(std::move(*longer));
    }
  }
  by_key();
}

void TargetSearch::by_key() {
  if (next_ == keys_.size()) return by_name();
  read_(keys_[next_++], [this](const std::vector<Tuple>& tuples) {
    for (const auto& tuple : tuples) found_.targets.push_back({tuple.owner, tuple.key});
    found_.targets.empty() ? by_key() : end(std::move(found_));
  });
}

void TargetSearch::by_name() {
  next_ = 0;
  read_names();
}

void TargetSearch::read_names() {
  const auto patterns = name_patterns();
  if (next_ < patterns.size()) {
    read_(patterns[next_++], [this](const std::vector<Tuple>& tuples) {
      add_names(tuples, names_);
      read_names();
    });
    return;
  }
  next_ = 0;
  points_ = points_called(names_, text_, wants_command() ? Among::kSettable : Among::kAll);
  read_points();
}

/// Sensors and actuators have the tuples that their device names; of a property only the tuples tell whether it can be
/// set.
void TargetSearch::read_points() {
  while (next_ < points_.size()) {
    const Target target{points_[next_].owner.value_or(model::kNoOwner),
                        fmt::format("{}.{}", points_[next_].key, last_)};
    const bool is_certain = !wants_command() || next_ >= kMaxRead || model::key_parts(target.key)[3] == "actuator";
    ++next_;
    if (!is_certain) {
      return read_({target.owner, target.key}, [this, target](const std::vector<Tuple>& tuples) {
        if (!tuples.empty()) found_.targets.push_back(target);
        read_points();
      });
    }
    found_.targets.push_back(target);
  }
  if (found_.targets.empty()) {
    found_.is_read_only = wants_command() && !points_called(names_, text_, Among::kAll).empty();
    found_.near = near_points(names_, text_, wants_command() ? Among::kSettable : Among::kAll);
  }
  end(std::move(found_));
}

/// Candidates are in the order in which people list them.
void TargetSearch::end(Result<Findings> findings) {
  if (findings) {
    std::sort(findings->targets.begin(), findings->targets.end(),
              [](const Target& a, const Target& b) { return base::natural_less(to_string(a), to_string(b)); });
  }
  const auto call = std::move(call_);
  call(std::move(findings));
}

}  // namespace rubicon::client
