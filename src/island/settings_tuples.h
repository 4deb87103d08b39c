#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "island/command_key.h"

namespace rubicon::island {

/// `<prefix>.settings`: the configuration in force, and the commands `try` and `reload`, which read its file again
/// (docs/tuple-keys.md). Lives as long as the island, so a reload that recreates networks does not lose its command.
class SettingsTuples {
 public:
  /// Longest text of the configuration in force, in bytes.
  static constexpr std::size_t kMostText = 512 * 1024;
  /// Changes and errors that one status names; the others are counted.
  static constexpr std::size_t kMostLines = 200;

  /// Reads the configuration again; the lines of what changed (or would change: `try_only`). The text of an error has a
  /// line for each fault, `file:line:column: what` where it has a place.
  using Outcome = Result<std::vector<std::string>>;
  using Reload = std::function<Outcome(bool try_only)>;

  explicit SettingsTuples(CommandKey::Place place);

  /// Without it both commands are refused.
  void on_reload(Reload reload) { reload_ = std::move(reload); }
  /// Publishes all tuples.
  void start();
  /// The configuration in force, as YAML without secrets.
  void show_text(const std::string& text);
  /// What came of a reload or an attempt, whoever asked for it.
  void show_outcome(bool try_only, const Outcome& outcome);

 private:
  Result<void> check(const std::string& text) const;
  Result<void> run(const std::string& text);
  nlohmann::ordered_json status() const;

  CommandKey::Place place_;
  Reload reload_;
  std::string what_;
  bool refused_ = false;
  WallTime at_{};
  nlohmann::ordered_json changes_ = nlohmann::ordered_json::array();
  nlohmann::ordered_json errors_ = nlohmann::ordered_json::array();
  CommandKey command_;
};

}  // namespace rubicon::island
