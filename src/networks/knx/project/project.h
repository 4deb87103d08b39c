#pragma once

#include <memory>
#include <string>
#include <vector>

#include "networks/knx/groups/import.h"
#include "networks/knx/project/archive.h"
#include "networks/knx/project/installation.h"
#include "networks/knx/secure/key.h"
#include "transport/transports.h"

namespace rubicon::networks::knx::project {

/// Schemas of ETS 4 to 6. A newer one is read, with a warning.
inline constexpr unsigned kOldestSchema = 11, kNewestSchema = 23;

struct ReadOptions {
  const secure::Secret* password = nullptr;  ///< UTF-8; nullptr = none was given
  ArchiveLimits limits{};
  std::size_t kept = kMaxKept;  ///< bytes that may be kept of it
};

/// A project of ETS.
struct Project {
  std::string id, name;  ///< `P-0242`
  unsigned schema = 0;
  bool was_protected = false;
  std::shared_ptr<KeptTexts> texts;         ///< of the installations
  std::vector<Installation> installations;  ///< without the names and descriptions of group addresses
  groups::GroupList list;                   ///< all group addresses; lines are those of 0.xml
};

/// Reads a .knxproj: ETS 4 to 6, plain or protected (knx.md, sections 13.4 and 21.9). Blocks: for start-up and tools. A
/// protected project of ETS 6 takes one PBKDF2. Application programs that cannot be read cost the types and flags
/// that only they know, with a warning. Of several installations with one address the first keeps it. `source` is the
/// file's name, for errors and the report. kRefused: the password is missing or wrong; kInvalid: no project, damaged,
/// or an unknown schema; kOutOfRange: beyond the limits.
Result<Project> read_project(std::unique_ptr<transport::FileSource> file, const std::string& source,
                             const ReadOptions& options = {});

/// True for a file that is a zip archive by its first bytes, or a project by its name.
Result<bool> is_project(transport::FileSource& file, const std::string& name);

/// The points of a project. The errors of read_project().
Result<groups::Import> import_project(std::unique_ptr<transport::FileSource> file, const std::string& source,
                                      const ReadOptions& how, const groups::ImportOptions& options = {});

}  // namespace rubicon::networks::knx::project
