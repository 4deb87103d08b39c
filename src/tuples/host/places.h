#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rubicon/result.hpp"

namespace rubicon::tuples::host {

/// The folder that the unit and the packages make.
inline constexpr const char* kInstalledFolder = "/run/rubicon";
inline constexpr const char* kDefaultSpace = "default";

/// Where the processes of a space meet.
struct Place {
  std::string path;
  /// Of several users: islands stand in `islands`, all others in `people/<uid>`. Else the folder of one person.
  bool shared = false;
};

/// What decides about the place besides the configuration.
struct Surroundings {
  std::string installed = kInstalledFolder;
  std::string given{};      ///< RUBICON_FOLDER
  std::string runtime{};    ///< XDG_RUNTIME_DIR
  std::string temporary{};  ///< the system's folder for temporary files
  static Surroundings of_process();
};

/// The place: the first of RUBICON_FOLDER, `configured`, the installed folder where this user may enter it, and the
/// person's own, which is `rubicon` in XDG_RUNTIME_DIR where that is this user's, else `rubicon-<uid>` in the folder
/// for temporary files. kInvalid for a path that is not absolute.
Result<Place> choose_place(const std::string& configured, const Surroundings& around);

/// A space is a name as in keys: 1 to 40 of `A-Za-z0-9_-`. kInvalid says so.
Result<void> check_space(const std::string& space);

}  // namespace rubicon::tuples::host
