#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "island/island_metrics.h"
#include "recorder/recorder.h"

namespace rubicon::island {

/// The recorders of an island as its configuration says.
class Recorders {
 public:
  /// `place.directory` is not used: each configuration brings its own.
  explicit Recorders(recorder::Recorder::Context context) : context_(std::move(context)) {}

  /// Starts new recorders, ends removed ones, and restarts changed ones; the others are not touched.
  void take(const std::vector<config::RecorderSetup>& setups, const std::string& directory);

  /// `recorder-<name>-records` and so on, of each.
  void publish_counters(const IslandMetrics::Publish& publish) const;
  /// Gets the name of each recorder and the path that it writes to.
  void each(const std::function<void(const std::string& name, const std::string& path)>& visit) const;

 private:
  recorder::Recorder::Context context_;
  std::vector<std::unique_ptr<recorder::Recorder>> all_;
};

}  // namespace rubicon::island
