#include "island/recorders.h"

#include <algorithm>

#include "base/text.h"

namespace rubicon::island {

void Recorders::take(const std::vector<config::RecorderSetup>& setups, const std::string& directory) {
  const bool moved = directory != context_.directory;
  context_.directory = directory;
  // All that end first: two recorders may swap their files.
  std::erase_if(all_, [&](const auto& recorder) {
    return moved || std::find(setups.begin(), setups.end(), recorder->setup()) == setups.end();
  });
  for (const auto& setup : setups) {
    const bool runs =
        std::any_of(all_.begin(), all_.end(), [&](const auto& recorder) { return recorder->setup() == setup; });
    if (runs) continue;
    all_.push_back(std::make_unique<recorder::Recorder>(setup, context_));
    all_.back()->start();
  }
}

void Recorders::publish_counters(const IslandMetrics::Publish& publish) const {
  for (const auto& recorder : all_) {
    const auto prefix = "recorder-" + recorder->setup().name + "-";
    const auto& counters = recorder->counters();
    publish.word(prefix + "state", recorder->state());
    publish(prefix + "records", counters.records);
    publish(prefix + "bytes", counters.bytes);
    publish(prefix + "dropped", counters.dropped);
    publish(prefix + "files", counters.files);
    publish(prefix + "failures", counters.failures);
    publish(prefix + "cut", counters.cut);
  }
}

void Recorders::each(const std::function<void(const std::string& name, const std::string& path)>& visit) const {
  for (const auto& recorder : all_)
    visit(recorder->setup().name, base::resolve_path(context_.directory, recorder->setup().file));
}

}  // namespace rubicon::island
