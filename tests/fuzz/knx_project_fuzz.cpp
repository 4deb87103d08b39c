#include <cstdlib>
#include <set>
#include <string_view>

#include "fuzz_target.h"
#include "networks/knx/groups/group_file.h"
#include "networks/knx/project/project.h"
#include "networks/knx/project/zip_source.h"
#include "support/knx_project.h"

namespace rubicon::fuzz::knx_project_fuzz {

namespace {

using namespace rubicon::networks::knx;

constexpr std::string_view kBetween = "\n====\n";
constexpr const char* kNames[] = {"knx_master.xml", "P-00F1/project.xml", "P-00F1/0.xml", "M-00FA/Hardware.xml",
                                  "M-00FA/M-00FA_A-0001-01-0001.xml"};

/// The address that reports the state of another is no point of its own.
void check(const std::vector<groups::GroupPoint>& points) {
  std::set<wire::GroupAddress> all;
  for (const auto& point : points) {
    if (!all.insert(point.address).second) std::abort();
    if (point.state && !all.insert(*point.state).second) std::abort();
    if (point.state && point.kind != rubicon::Kind::kActuator) std::abort();
  }
}

}  // namespace

/// Input: the XML documents of a project in this order, with a line `====` between.
FUZZ_TARGET(knx_project) {
  std::string_view text(reinterpret_cast<const char*>(data), size);
  std::vector<rubicon::support::ZipEntry> entries;
  for (const auto* name : kNames) {
    const auto end = std::min(text.find(kBetween), text.size());
    entries.push_back({name, std::string(text.substr(0, end))});
    text.remove_prefix(std::min(end + kBetween.size(), text.size()));
  }
  const auto bytes = rubicon::support::zip_of(entries);
  auto project = project::read_project(project::file_of({bytes.begin(), bytes.end()}), "fuzz.knxproj");
  if (!project) return 0;
  if (project->list.report.taken != project->list.entries.size()) std::abort();
  check(groups::import_list(std::move(project->list)).points);
  return 0;
}

}  // namespace rubicon::fuzz::knx_project_fuzz
