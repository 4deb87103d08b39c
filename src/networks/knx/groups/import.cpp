#include "networks/knx/groups/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "networks/knx/groups/encoding.h"
#include "networks/knx/groups/group_file.h"
#include "networks/knx/groups/group_list.h"
#include "networks/knx/groups/infer_points.h"

namespace rubicon::networks::knx::groups {

std::vector<wire::GroupAddress> read_secured_groups(ConfigReader& reader) {
  std::set<wire::GroupAddress> found;
  for (const auto& text : reader.texts("secured-groups")) {
    const auto address = wire::parse_group(text);
    address ? void(found.insert(*address)) : reader.error("secured-groups", address.error().text);
  }
  return {found.begin(), found.end()};
}

std::vector<wire::GroupAddress> secured_of(const GroupList& list) {
  std::set<wire::GroupAddress> found;
  for (const auto& entry : list.entries) {
    if (entry.secured) found.insert(entry.address);
  }
  return {found.begin(), found.end()};
}

std::vector<wire::GroupAddress> merge_secured(const std::vector<wire::GroupAddress>& known, const GroupList& imported,
                                              Report& report) {
  std::set<wire::GroupAddress> all(known.begin(), known.end());
  for (const auto& entry : imported.entries) {
    if (entry.secured && all.insert(entry.address).second)
      report.note(0, entry.address, "secured from now on: its key is in the keyring");
    const bool is_plain = !entry.secured && (imported.knows_plain || to_lower(entry.security) == "off");
    if (is_plain && all.erase(entry.address) != 0)
      report.warning(0, entry.address, "no longer secured: plain telegrams are sent and taken");
  }
  return {all.begin(), all.end()};
}

std::vector<wire::GroupAddress> joined(const std::vector<wire::GroupAddress>& one,
                                       const std::vector<wire::GroupAddress>& other) {
  std::vector<wire::GroupAddress> all;
  std::set_union(one.begin(), one.end(), other.begin(), other.end(), std::back_inserter(all));
  return all;
}

namespace {

/// Sorts findings by line, those that concern no line last.
void sort_findings(Report& report) {
  const auto rank = [](const Finding& finding) { return finding.line - 1; };  // 0 becomes the largest
  std::stable_sort(report.findings.begin(), report.findings.end(),
                   [&](const Finding& a, const Finding& b) { return rank(a) < rank(b); });
}

std::vector<GroupPoint> points_for(const GroupList& list, const ImportOptions& options, Report& report) {
  auto points = infer_points(list.entries, options.guess, report);
  if (!options.known) return points;
  return merge(*options.known, points, report);
}

}  // namespace

Result<Import> import_text(std::string_view text, const std::string& source, const ImportOptions& options) {
  auto list = read_group_list(text);
  list.report.source = source;
  if (list.report.refused) {
    const auto& why = list.report.findings.front();
    return fail(ErrorCode::kInvalid, why.line == 0 ? fmt::format("{}: {}", source, why.text)
                                                   : fmt::format("{}:{}: {}", source, why.line, why.text));
  }
  return import_list(std::move(list), options);
}

Import import_list(GroupList list, const ImportOptions& options) {
  Import out;
  auto report = std::move(list.report);
  out.points = points_for(list, options, report);
  out.secured = options.known ? merge_secured(options.known_secured, list, report) : secured_of(list);
  sort_findings(report);
  out.report = std::move(report);
  return out;
}

Result<Import> import_file(const std::string& path, const ImportOptions& options) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) return fail(ErrorCode::kNotFound, fmt::format("{}: no such file", path));
  if (!std::filesystem::is_regular_file(status))
    return fail(ErrorCode::kIo, fmt::format("{}: is not a regular file", path));
  const auto size = std::filesystem::file_size(path, error);
  if (error) return fail(ErrorCode::kIo, fmt::format("{}: {}", path, error.message()));
  if (size > kMaxListBytes)
    return fail(ErrorCode::kOutOfRange, fmt::format("{}: has {} bytes, expected at most 64 MiB", path, size));
  std::ifstream file(path, std::ios::binary);
  std::string text(size, '\0');
  file.read(text.data(), static_cast<std::streamsize>(size));
  if (!file) return fail(ErrorCode::kIo, fmt::format("{}: cannot be read", path));
  return import_text(text, std::filesystem::path(path).filename().string(), options);
}

}  // namespace rubicon::networks::knx::groups
