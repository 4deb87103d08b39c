#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "island/island_commands.h"
#include "island/island_tuples.h"
#include "recorder/recorder.h"

namespace rubicon::island {

/// A recorder of the configuration, which users stop, start and mark by `<prefix>.recorder.<name>.command`. Its
/// counters go on over a stop.
class RecorderSwitch {
 public:
  /// Starts the recorder.
  RecorderSwitch(config::RecorderSetup setup, const recorder::Recorder::Context& context,
                 const proxy::ProxyConfig& config);

  const config::RecorderSetup& setup() const { return setup_; }
  recorder::Recorder::Counters counters() const;
  /// `stopped`, or as recorder::Recorder::state().
  std::string state() const { return recorder_ ? recorder_->state() : "stopped"; }
  /// Publishes what changed.
  void show() { command_.show(); }

 private:
  Result<void> check(const std::string& text) const;
  Result<void> run(const std::string& text);
  void start();
  void stop();
  nlohmann::ordered_json status();

  config::RecorderSetup setup_;
  recorder::Recorder::Context context_;
  std::unique_ptr<recorder::Recorder> recorder_;  ///< nullptr: stopped
  recorder::Recorder::Counters before_;           ///< of the recorders that were stopped
  std::uint64_t size_ = 0;                        ///< of the file when it was last open
  std::string word_;                              ///< as last shown
  WallTime since_{};                              ///< of word_
  CommandKey command_;
};

/// The recorders of an island as its configuration names them.
class Recorders {
 public:
  /// `context.directory` is not used: each configuration brings its own. `config` must outlive it.
  Recorders(recorder::Recorder::Context context, const proxy::ProxyConfig& config)
      : context_(std::move(context)), config_(config) {}

  /// Starts new recorders, ends removed ones, and restarts changed ones; the others are not touched, also if a user
  /// stopped them.
  void take(const std::vector<config::RecorderSetup>& setups, const std::string& directory);

  /// `recorder-<name>-records` and so on, of each.
  void publish_counters(const IslandMetrics::Publish& publish) const;
  /// Publishes the statuses that changed.
  void show() const;
  /// Gets the name of each recorder and the path that it writes to.
  void each(const std::function<void(const std::string& name, const std::string& path)>& visit) const;

 private:
  recorder::Recorder::Context context_;
  const proxy::ProxyConfig& config_;
  std::vector<std::unique_ptr<RecorderSwitch>> all_;
};

}  // namespace rubicon::island
