#include <cstdlib>

#include "fuzz_target.h"
#include "networks/knx/groups/group_file.h"
#include "networks/knx/project/project.h"
#include "networks/knx/project/zip_source.h"

namespace rubicon::fuzz::knx_archive_fuzz {

/// Input: a project of ETS (.knxproj), plain or with the password `flatpass`.
FUZZ_TARGET(knx_archive) {
  using namespace rubicon::networks::knx;
  static const auto password = secure::Secret::of_text("flatpass");
  project::ArchiveLimits limits;
  limits.unpacked = limits.inner_archive = std::uint64_t{4} << 20U;
  auto project = project::read_project(project::file_of({data, data + size}), "fuzz.knxproj", {&password, limits});
  if (!project) {
    if (project.error().text.find("flatpass") != std::string::npos) std::abort();
    return 0;
  }
  if (project->list.report.taken != project->list.entries.size()) std::abort();
  const auto count = project->list.entries.size();
  if (groups::import_list(std::move(project->list)).points.size() > count) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::knx_archive_fuzz
