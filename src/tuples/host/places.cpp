#include "tuples/host/folder.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>

namespace rubicon::tuples::host {

namespace fs = std::filesystem;

namespace {

constexpr int kDepth = 3;  ///< <place>/people/<uid>/<space>

constexpr std::size_t kMaxSpace = 40;

std::string variable(const char* name) {
  const auto* value = std::getenv(name);
  return value ? value : "";
}

bool is_shared(const std::string& path) {
  struct stat islands {};
  return ::stat((path + "/islands").c_str(), &islands) == 0 && S_ISDIR(islands.st_mode);
}

/// Entries that are read of a folder that others fill, too.
void each_entry(const std::string& folder, const std::function<void(const fs::path& path)>& call) {
  constexpr int kMaxCount = 10'000;
  std::error_code hidden;
  fs::directory_iterator one(folder, hidden);
  for (int count = 0; !hidden && one != fs::directory_iterator() && count < kMaxCount; one.increment(hidden), ++count)
    call(one->path());
}

/// Whether a socket stands in a folder below.
bool has_components(const fs::path& path) {
  std::error_code hidden;
  int left = 10'000;
  for (fs::recursive_directory_iterator one(path, fs::directory_options::skip_permission_denied, hidden), end;
       !hidden && one != end && --left > 0; one.increment(hidden)) {
    if (one.depth() > kDepth) one.disable_recursion_pending();
    if (one->path().extension() == ".sock") return true;
  }
  return false;
}

bool is_own_folder(const std::string& path) {
  struct stat found {};
  return ::stat(path.c_str(), &found) == 0 && S_ISDIR(found.st_mode) && found.st_uid == ::geteuid();
}

/// `./run` writes the file.
std::string folder_beside_program() {
  std::error_code error;
  std::string path;
  std::ifstream file(fs::read_symlink("/proc/self/exe", error).parent_path() / "rubicon.folder");
  return std::getline(file, path) && is_own_folder(path) ? path : "";
}

}  // namespace

Surroundings Surroundings::of_process() {
  Surroundings around;
  around.given = variable("RUBICON_FOLDER");
  if (around.given.empty()) around.beside = folder_beside_program();
  around.runtime = variable("XDG_RUNTIME_DIR");
  around.temporary = variable("TMPDIR");
  if (around.temporary.empty()) around.temporary = "/tmp";
  return around;
}

Result<Place> choose_place(const std::string& configured, const Surroundings& around) {
  for (const auto& [path, from] : {std::pair(around.given, "RUBICON_FOLDER"), std::pair(configured, "tuples.folder")}) {
    if (path.empty()) continue;
    if (path.front() != '/')
      return fail(ErrorCode::kInvalid, fmt::format("{}: {}: expected an absolute path", from, path));
    return Place{path, is_shared(path)};
  }
  if (!around.beside.empty()) return Place{around.beside, is_shared(around.beside)};
  if (is_shared(around.installed) && ::access(around.installed.c_str(), X_OK) == 0)
    return Place{around.installed, true};
  if (!around.runtime.empty() && is_own_folder(around.runtime)) return Place{around.runtime + "/rubicon", false};
  return Place{fmt::format("{}/rubicon-{}", around.temporary, ::geteuid()), false};
}

std::vector<std::string> other_places(const std::string& used, const Surroundings& around) {
  std::vector<std::string> all{around.installed};
  const auto add = [&all](const fs::path& path, const std::string& user) {
    struct stat found {};
    if (::lstat(path.c_str(), &found) == 0 && S_ISDIR(found.st_mode) && user == std::to_string(found.st_uid))
      all.push_back(path.string());
  };
  constexpr std::string_view kOwn = "rubicon-";
  each_entry(around.people, [&](const fs::path& path) { add(path / "rubicon", path.filename().string()); });
  each_entry(around.temporary, [&](const fs::path& path) {
    const auto name = path.filename().string();
    if (name.starts_with(kOwn)) add(path, name.substr(kOwn.size()));
  });
  std::erase_if(all, [&](const auto& path) { return path == used || !has_components(path); });
  std::sort(all.begin(), all.end());
  return all;
}

bool is_shut_out(const Surroundings& around) {
  struct stat found {};
  return ::stat(around.installed.c_str(), &found) == 0 && ::access(around.installed.c_str(), X_OK) != 0;
}

std::string choose_space(const std::string& configured) {
  const auto given = variable("RUBICON_SPACE");
  if (!given.empty()) return given;
  return configured.empty() ? kDefaultSpace : configured;
}

std::string space_of(std::uint32_t domain, const std::string& tag) {
  return tag.empty() ? fmt::format("d{}", domain) : fmt::format("d{}-{}", domain, tag);
}

Result<void> check_space(const std::string& space) {
  const auto fits = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           c == '.';
  };
  if (!space.empty() && space.size() <= kMaxSpace && space.front() != '.' &&
      std::all_of(space.begin(), space.end(), fits))
    return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("'{}' is not a space, expected 1 to {} characters of A-Z a-z 0-9 . _ -, the first no dot",
                          space, kMaxSpace));
}

}  // namespace rubicon::tuples::host
