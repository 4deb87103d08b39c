#include "island/settings_tuples.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "base/masked.h"
#include "base/text.h"
#include "model/json_members.h"
#include "model/type_catalogue.h"
#include "rubicon/key.hpp"

namespace rubicon::island {

namespace {

using Json = nlohmann::ordered_json;

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    if (end > 0) lines.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

/// `home.yaml:3:7: what` in its parts. A line without a place is all text.
Json error_of(std::string_view line) {
  for (auto colon = line.find(':'); colon != line.npos; colon = line.find(':', colon + 1)) {
    const auto second = line.find(':', colon + 1);
    const auto third = second == line.npos ? line.npos : line.find(": ", second + 1);
    if (third == line.npos) break;
    const auto row = base::parse_number<unsigned>(line.substr(colon + 1, second - colon - 1));
    const auto column = base::parse_number<unsigned>(line.substr(second + 1, third - second - 1));
    if (!row || !column) continue;
    return {{"file", line.substr(0, colon)},
            {"line", *row},
            {"column", *column},
            {"text", base::masked(line.substr(third + 2))}};
  }
  return {{"line", 0}, {"column", 0}, {"text", base::masked(line)}};
}

std::string more_lines(std::size_t count) {
  return fmt::format("... and {} more", count);
}

/// What `item` makes of each line; the last one counts those that are too many.
template <class Lines, class Item>
Json listed(const Lines& lines, Item item) {
  auto all = Json::array();
  for (const auto& line : lines) {
    const bool full = all.size() == SettingsTuples::kMostLines;
    all.push_back(full ? item(more_lines(lines.size() - all.size())) : item(line));
    if (full) break;
  }
  return all;
}

}  // namespace

SettingsTuples::SettingsTuples(CommandKey::Place place)
    : place_(place),
      command_(place, model::IslandKey{place.config.prefix}.settings(),
               {[this](const std::string& text) { return check(text); },
                [this](const std::string& text) { return run(text); }, [this] { return status(); }}) {}

void SettingsTuples::start() {
  model::PointDescription about;
  about.type = "settings";
  about.data_type = "enumeration";
  about.words = {{0, "try"}, {1, "reload"}};
  about.access = to_string(model::Access::kWrite);
  about.report = "event";
  command_.describe(about);
  command_.show();
}

void SettingsTuples::show_text(const std::string& text) {
  const auto key = command_.key().value();
  const auto before = place_.space.get(place_.space.self(), key);
  if (before && before->value == text) return;
  std::ignore = place_.space.set(key, text, {"application/yaml", {}, {}});
}

Result<void> SettingsTuples::check(const std::string& text) const {
  if (text != "try" && text != "reload")
    return fail(ErrorCode::kInvalid, fmt::format("{}, expected try or reload", model::quoted(text)));
  if (!reload_) return fail(ErrorCode::kUnsupported, "this program cannot read its configuration again");
  return {};
}

Result<void> SettingsTuples::run(const std::string& text) {
  const bool try_only = text == "try";
  const auto outcome = reload_(try_only);
  show_outcome(try_only, outcome);
  if (outcome) return {};
  const auto lines = lines_of(outcome.error().text);
  const auto first = lines.empty() ? std::string() : base::masked(lines.front());
  return fail(ErrorCode::kRefused,
              lines.size() < 2 ? first : fmt::format("{} {}", first, more_lines(lines.size() - 1)));
}

void SettingsTuples::show_outcome(bool try_only, const Outcome& outcome) {
  what_ = try_only ? "try" : "reload";
  refused_ = !outcome.has_value();
  at_ = place_.scheduler.wall_now();
  changes_ = errors_ = Json::array();
  if (outcome) {
    changes_ = listed(*outcome, [](std::string_view line) { return Json(base::masked(line)); });
  } else {
    errors_ = listed(lines_of(outcome.error().text), error_of);
  }
  command_.show();
}

nlohmann::ordered_json SettingsTuples::status() const {
  const auto* state = what_.empty() ? "idle" : refused_ ? "refused" : "ok";
  return {
      {"state", state}, {"what", what_}, {"at", model::seconds_json(at_)}, {"changes", changes_}, {"errors", errors_}};
}

}  // namespace rubicon::island
