#include "config/storage_config.h"

#include <fmt/format.h>

#include <utility>

#include "model/point_keys.h"
#include "model/type_names.h"
#include "recording/block_builder.h"

namespace rubicon::config {

namespace {

constexpr std::uint64_t kMinFileBound = 64 << 10;
constexpr Duration kMinFileBytes = std::chrono::seconds(10);
/// Its counters are called `recorder-<name>-failures`, and that is one key part.
constexpr std::size_t kMaxNameText = 40;

bool says_never(ConfigReader& map, const std::string& key, std::string_view word) {
  return map.has(key) && map.here().find(key)->text == word;
}

Rotation read_rotation(ConfigReader rotate) {
  Rotation out;
  if (says_never(rotate, "size", "never")) {
    rotate.node("size");
    out.size.reset();
  } else {
    out.size = rotate.size("size", *out.size, kMinFileBound);
  }
  out.every = rotate.duration_or_never("every", out.every);
  if (out.every && *out.every < kMinFileBytes) rotate.error("every", "expected at least 10s, or never");
  if (says_never(rotate, "keep", "all")) {
    rotate.node("keep");
    out.keep.reset();
  } else {
    out.keep = static_cast<std::size_t>(rotate.integer("keep", static_cast<std::int64_t>(*out.keep), 0, 100'000));
  }
  rotate.finish();
  return out;
}

std::vector<Pattern> read_patterns(ConfigReader& recorder) {
  std::vector<Pattern> patterns;
  for (const auto& text : recorder.texts("patterns")) {
    auto pattern = Pattern::parse(text);
    if (pattern) {
      if (auto now = model::current_key(pattern->key); now != pattern->key) patterns.push_back({pattern->owner, now});
      patterns.push_back(std::move(*pattern));
    } else {
      recorder.error("patterns", pattern.error().text);
    }
  }
  if (!recorder.has("patterns")) recorder.error("", "'patterns' is missing, expected for example [\"proxy.**\"]");
  if (recorder.has("patterns") && recorder.texts("patterns").empty())
    recorder.error("patterns", "is empty, expected for example [\"proxy.**\"]");
  return patterns;
}

}  // namespace

std::vector<RecorderSetup> read_recorders(ConfigReader& root) {
  std::vector<RecorderSetup> all;
  std::map<std::string, std::string> files;
  for (auto& [name, recorder] : root.maps("recorders")) {
    RecorderSetup setup;
    setup.name = name;
    if (name != model::to_key_part(name) || name.size() > kMaxNameText)
      recorder.error("", "a recorder's name has [A-Za-z0-9_-]+, at most 40 characters");
    setup.file = recorder.required_text("file", "the file to write, such as all.rec");
    if (recorder.has("file") && setup.file.empty()) recorder.error("file", "empty path, expected a file");
    const auto [other, fresh] = files.emplace(setup.file, name);
    if (!fresh) recorder.error("file", fmt::format("is written by recorder '{}' already", other->second));
    setup.patterns = read_patterns(recorder);
    setup.active = recorder.boolean("active", false);
    setup.minimum = recorder.duration("minimum", Duration(0));
    setup.rotation = read_rotation(recorder.map("rotate"));
    setup.compression =
        static_cast<int>(recorder.integer("compression", recording::kUsual, recording::kFastest, recording::kSmallest));
    recorder.finish();
    all.push_back(std::move(setup));
  }
  return all;
}

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
  if (setup.raw && *setup.raw < kMinRaw) history.error("raw", "expected at least 1h, or never");
  setup.hours = history.duration_or_never("hours", setup.hours);
  setup.size = history.size("size", setup.size, kMinHistory);
  history.finish();
  return setup;
}

}  // namespace rubicon::config
