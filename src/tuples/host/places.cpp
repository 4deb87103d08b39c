#include "tuples/host/places.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

namespace rubicon::tuples::host {

namespace {

constexpr std::size_t kMaxSpace = 40;

std::string variable(const char* name) {
  const auto* value = std::getenv(name);
  return value ? value : "";
}

bool is_shared(const std::string& path) {
  struct stat islands {};
  return ::stat((path + "/islands").c_str(), &islands) == 0 && S_ISDIR(islands.st_mode);
}

bool is_own_folder(const std::string& path) {
  struct stat found {};
  return ::stat(path.c_str(), &found) == 0 && S_ISDIR(found.st_mode) && found.st_uid == ::geteuid();
}

}  // namespace

Surroundings Surroundings::of_process() {
  const auto temporary = variable("TMPDIR");
  return {kInstalledFolder, variable("RUBICON_FOLDER"), variable("XDG_RUNTIME_DIR"),
          temporary.empty() ? "/tmp" : temporary};
}

Result<Place> choose_place(const std::string& configured, const Surroundings& around) {
  for (const auto& [path, from] : {std::pair(around.given, "RUBICON_FOLDER"), std::pair(configured, "tuples.folder")}) {
    if (path.empty()) continue;
    if (path.front() != '/')
      return fail(ErrorCode::kInvalid, fmt::format("{}: {}: expected an absolute path", from, path));
    return Place{path, is_shared(path)};
  }
  if (is_shared(around.installed) && ::access(around.installed.c_str(), X_OK) == 0)
    return Place{around.installed, true};
  if (!around.runtime.empty() && is_own_folder(around.runtime)) return Place{around.runtime + "/rubicon", false};
  return Place{fmt::format("{}/rubicon-{}", around.temporary, ::geteuid()), false};
}

Result<void> check_space(const std::string& space) {
  const auto fits = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  if (!space.empty() && space.size() <= kMaxSpace && std::all_of(space.begin(), space.end(), fits)) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("space '{}': expected 1 to {} characters of A-Z a-z 0-9 _ -", space, kMaxSpace));
}

}  // namespace rubicon::tuples::host
