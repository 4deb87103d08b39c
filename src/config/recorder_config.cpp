#include "config/recorder_config.h"

#include <fmt/format.h>

#include "model/former_types.h"
#include "recording/block_builder.h"

namespace rubicon::config {

namespace {

constexpr std::uint64_t kSmallestFile = 64 << 10;
constexpr Duration kShortestFile = std::chrono::seconds(10);
/// Its counters are called `recorder-<name>-failures`, and that is one key part.
constexpr std::size_t kLongestName = 40;

bool says_never(ConfigReader& map, const std::string& key, std::string_view word) {
  return map.has(key) && map.here().find(key)->text == word;
}

Rotation read_rotation(ConfigReader rotate) {
  Rotation out;
  if (says_never(rotate, "size", "never")) {
    rotate.node("size");
    out.size.reset();
  } else {
    out.size = rotate.size("size", *out.size, kSmallestFile);
  }
  out.every = rotate.duration_or_never("every", out.every);
  if (out.every && *out.every < kShortestFile) rotate.error("every", "expected at least 10s, or never");
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
    if (name != model::to_key_part(name) || name.size() > kLongestName)
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

}  // namespace rubicon::config
