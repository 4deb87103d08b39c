#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"

namespace rubicon::island {

/// A change of the configuration file that a user asks for (docs/tuple-keys.md, `proxy.settings.command`).
struct ConfigChange {
  enum class Kind : std::uint8_t {
    kAdd,     ///< a network with these options
    kImport,  ///< another group file for a network
    kUndo     ///< back to the previous file
  };
  Kind kind = Kind::kUndo;
  std::string network, options;
  std::string groups;     ///< content of the group file; empty = none
  bool try_only = false;  ///< says what it would do

  /// `add`, `import`, `undo`.
  std::string_view word() const;
};

/// The file, for people.
struct ConfigFacts {
  std::string name;
  std::string fixed;      ///< why it cannot be changed; empty = it can
  bool previous = false;  ///< there is one to return to
  std::string patch;      ///< of the last change
};

/// Whether the text of a command asks for a change of the file.
bool is_config_change(std::string_view text);
/// `undo`, or JSON {do, network, options, groups, try}. kInvalid with what was expected.
Result<ConfigChange> read_config_change(std::string_view text);

/// Changes the file of a running island, and takes such a change back. Nothing is written before the new text was read
/// and planned as a reload does it; the present file stays beside it as `<file>.previous`. Only a file that is in force
/// is changed. Blocks for the disk.
class ConfigDesk {
 public:
  using Lines = std::vector<std::string>;
  /// Each calls back into the daemon; an error has a line for each fault.
  struct Calls {
    /// What a reload of this text would do.
    std::function<Result<Lines>(const std::string& text)> plan;
    /// Reads the file again and takes it. Calls took().
    std::function<Result<Lines>()> reload;
    /// Whether the island has a network of this name, also by its command line.
    std::function<bool(const std::string& network)> has_network;
  };

  ConfigDesk(std::string file, Calls calls) : file_(std::move(file)), calls_(std::move(calls)) {}

  /// The content of the file. kNotFound, kIo, kOutOfRange.
  Result<std::string> read() const;
  /// This text is in force from now on.
  void took(std::string_view text);
  /// kRefused: the file is not what is in force, or cannot be written; kDuplicate: the name is taken; otherwise what is
  /// wrong with the change, with its place. After an error the file is as before.
  Result<Lines> carry_out(const ConfigChange& change);
  ConfigFacts facts() const;

 private:
  Result<std::string> changed(const std::string& text, const ConfigChange& change, const std::string& groups) const;
  Result<Lines> plan_with_groups(const std::string& text, const ConfigChange& change) const;
  Result<Lines> apply(const std::string& text, const ConfigChange& change, const std::string& groups);
  Result<Lines> undo(const std::string& text, bool try_only);
  Result<Lines> replace(const std::string& before, const std::string& text);
  Result<void> check_in_force(const std::string& text) const;
  static std::string patch_of(const ConfigChange& change, const std::string& groups);
  static Error fixed(const std::string& why);
  std::string why_fixed() const;
  std::string fresh_groups(const std::string& network) const;
  std::string previous_path() const;

  std::string file_;
  Calls calls_;
  std::size_t in_force_ = 0;  ///< digest of the text
  std::string patch_;
};

}  // namespace rubicon::island
