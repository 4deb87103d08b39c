#pragma once

#include <cstdint>
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
  std::string beside{};     ///< a folder that stands in the file `rubicon.folder` beside the program, if it exists
  std::string runtime{};    ///< XDG_RUNTIME_DIR
  std::string temporary{};  ///< the system's folder for temporary files
  std::string people = "/run/user";  ///< where folders as XDG_RUNTIME_DIR stand
  static Surroundings of_process();
};

/// The place: the first of RUBICON_FOLDER, `configured`, that of a demo of the same tree, the installed folder where
/// this user may enter it, and the person's own, which is `rubicon` in XDG_RUNTIME_DIR where that is this user's, else
/// `rubicon-<uid>` in the folder for temporary files. kInvalid for a path that is not absolute.
Result<Place> choose_place(const std::string& configured, const Surroundings& around);

/// Other folders of this host where components are, as far as this user may see: of people, and the installed one.
std::vector<std::string> other_places(const std::string& used, const Surroundings& around);
/// Whether the installed folder is there, and closed to this user.
bool is_shut_out(const Surroundings& around);

/// RUBICON_SPACE, else the configured one, else `default`.
std::string choose_space(const std::string& configured);

/// The space of a host that takes the place of a DDS domain with a tag: `d3-<tag>`.
std::string space_of(std::uint32_t domain, const std::string& tag);

/// A space has 1 to 40 of `A-Za-z0-9._-`, and begins with no dot. kInvalid says so.
Result<void> check_space(const std::string& space);

}  // namespace rubicon::tuples::host
