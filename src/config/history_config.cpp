#include "config/history_config.h"

#include <utility>

#include "model/point_keys.h"

namespace rubicon::config {

namespace {

std::vector<Pattern> patterns_in(ConfigReader& history, const std::string& key) {
  std::vector<Pattern> patterns;
  for (const auto& text : history.texts(key)) {
    auto pattern = Pattern::parse(text);
    if (pattern) {
      patterns.push_back(std::move(*pattern));
    } else {
      history.error(key, pattern.error().text);
    }
  }
  return patterns;
}

}  // namespace

std::vector<Pattern> usual_history() {
  return {{std::nullopt, model::any_point().value()}};
}

std::optional<HistorySetup> read_history(ConfigReader& root) {
  if (!root.has("history")) return std::nullopt;
  auto history = root.map("history");
  HistorySetup setup;
  setup.file = history.required_text("file", "the file that keeps the values, such as home.history");
  if (history.has("file") && setup.file.empty()) history.error("file", "empty path, expected a file");
  if (auto patterns = patterns_in(history, "patterns"); history.has("patterns")) {
    setup.patterns = std::move(patterns);
    if (history.texts("patterns").empty())
      history.error("patterns", "is empty, expected for example [\"*:*.*.*.*.*.value\"]");
  }
  setup.exclude = patterns_in(history, "exclude");
  setup.minimum = history.duration("minimum", setup.minimum);
  setup.dead_band = history.real("deadband", setup.dead_band, 0);
  setup.raw = history.duration_or_never("raw", setup.raw);
  if (setup.raw && *setup.raw < kShortestRaw) history.error("raw", "expected at least 1h, or never");
  setup.hours = history.duration_or_never("hours", setup.hours);
  setup.size = history.size("size", setup.size, kSmallestHistory);
  history.finish();
  return setup;
}

}  // namespace rubicon::config
