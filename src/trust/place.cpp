#include "trust/place.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string_view>

#include "trust/chosen_member.h"
#include "trust/started_realm.h"
#include "trust/trust_folder.h"

namespace rubicon::trust {

namespace {

namespace fs = std::filesystem;

constexpr const char* kVariable = "RUBICON_TRUST";
constexpr const char* kCredential = "trust-key";

/// Empty if the variable is not set.
std::string_view environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string_view() : value;
}

/// 0, or why it cannot be seen. A symbolic link counts, wherever it points.
int fault_at(const fs::path& path) {
  struct stat about {};
  return ::lstat(path.c_str(), &about) == 0 ? 0 : errno;
}

/// Whether there is a realm, or something that hides whether there is: who opens it gets the error.
bool may_have_realm(const fs::path& folder) {
  const int fault = fault_at(folder);
  if (fault == ENOENT || fault == ENOTDIR) return false;
  struct stat about {};
  if (::stat(folder.c_str(), &about) != 0) return true;
  return fault_at(folder / kIdentityCaFile) != ENOENT;
}

std::string user_name() {
  std::array<char, 16384> texts{};
  passwd entry{};
  passwd* found = nullptr;
  if (::getpwuid_r(::geteuid(), &entry, texts.data(), texts.size(), &found) != 0 || found == nullptr)
    return fmt::format("{}", ::geteuid());
  return found->pw_name;
}

tl::unexpected<Error> not_in_group(const fs::path& path) {
  const auto user = user_name();
  return fail(ErrorCode::kRefused,
              fmt::format("{}: {} may not use the key of this host: run `sudo adduser {} rubicon` and log in again",
                          path.string(), user, user));
}

/// kNotFound with `expected`: the folder has no realm, or with what to do: it had one that is lost. Other errors: this
/// user cannot see whether it has.
Result<void> check_has_realm(const fs::path& folder, std::string_view expected) {
  const auto file = folder / kIdentityCaFile;
  const int fault = fault_at(file);
  if (fault == 0) return {};
  if (fault == EACCES) return not_in_group(folder);
  if (fault != ENOENT && fault != ENOTDIR)
    return fail(ErrorCode::kIo, fmt::format("{}: cannot be read: {}", file.string(), std::strerror(fault)));
  if (auto lost = StartedRealm(folder).check_is_there(); !lost) return lost;
  return fail(ErrorCode::kNotFound, fmt::format("{}: has no realm: {}", folder.string(), expected));
}

fs::path key_of(const Place& place) {
  return place.key.empty() ? place.folder / key_file(place.member) : place.key;
}

/// 0, or why this process may not read it.
int fault_of_reading(const fs::path& path) {
  return ::faccessat(AT_FDCWD, path.c_str(), R_OK, AT_EACCESS) == 0 ? 0 : errno;
}

/// What a key that this user may not read needs, so that they may.
tl::unexpected<Error> not_for_user(const Place& place) {
  const auto key = key_of(place);
  struct stat about {};
  const bool is_for_group = FolderFiles(place.folder).key_readers(key_file(place.member)) == KeyReaders::kPeople;
  if (is_for_group || ::lstat(key.c_str(), &about) != 0) return not_in_group(key);
  if (place.member != kLocalMember || about.st_uid != 0)
    return fail(ErrorCode::kRefused,
                fmt::format("{}: is for {} only: `rubicon trust dds join` takes a member of your own", key.string(),
                            about.st_uid == 0 ? "root" : "its owner"));
  const auto given = fmt::format("`sudo rubicon trust dds init{}`",
                                 place.folder == kHostFolder ? "" : " --trust " + place.folder.string());
  const auto user = user_name();
  if (!people_group())
    return fail(ErrorCode::kRefused,
                fmt::format("{}: this host has no group rubicon: run `sudo addgroup --system rubicon`, {} and `sudo "
                            "adduser {} rubicon`, then log in again",
                            key.string(), given, user));
  return fail(ErrorCode::kRefused, fmt::format("{}: is for root only: run {}, which gives it to the group rubicon, and "
                                               "`sudo adduser {} rubicon`, then log in again",
                                               key.string(), given, user));
}

/// kRefused with what helps, if this user may not read the key.
Result<Place> readable(Place place) {
  const int fault = fault_of_reading(key_of(place));
  if (fault == 0) return place;
  if (fault == EACCES) return not_for_user(place);
  return fail(ErrorCode::kNotFound, fmt::format("{}: the key of the member {} is not here: expected it in this folder",
                                                key_of(place).string(), place.member));
}

/// What systemd hands to this process.
struct Credential {
  fs::path key;          ///< empty = it has no key for it
  bool is_none = false;  ///< units without a key have the word `none` instead
};

Credential credential() {
  const auto credentials = environment("CREDENTIALS_DIRECTORY");
  if (credentials.empty()) return {};
  auto key = fs::path(credentials) / kCredential;
  std::string line;
  if (!std::getline(std::ifstream(key), line)) return {};
  if (line == "none") return {{}, true};
  return {std::move(key), false};
}

}  // namespace

fs::path user_folder() {
  const auto home = environment("HOME");
  return home.empty() ? fs::path() : fs::path(home) / ".config/rubicon/trust";
}

Result<Place> place_in(const fs::path& folder) {
  if (auto checked =
          check_has_realm(folder, "expected a folder that `rubicon trust dds init` or `rubicon trust dds join` made");
      !checked)
    return fail(checked.error());
  auto member = choose_member_of_people(folder);
  if (!member) return fail(member.error());
  return readable({folder, std::move(*member), {}, {}});
}

std::optional<fs::path> folder_of_user() {
  const auto asked = environment(kVariable);
  if (asked == "no") return {};
  if (!asked.empty()) return fs::path(asked);
  if (may_have_realm(user_folder())) return user_folder();
  return may_have_realm(kHostFolder) ? std::optional<fs::path>(kHostFolder) : std::nullopt;
}

Result<std::optional<Place>> place_of_user() {
  const auto folder = folder_of_user();
  if (!folder) return std::optional<Place>();
  auto place = place_in(*folder);
  if (!place) return fail(place.error());
  return std::optional<Place>(std::move(*place));
}

std::optional<fs::path> hidden_key(const Place& place) {
  auto key = key_of(place);
  return fault_of_reading(key) == EACCES ? std::optional(std::move(key)) : std::nullopt;
}

Result<Place> place_of_island(const fs::path& folder, OwnerId island) {
  if (auto checked =
          check_has_realm(folder, "`rubicon trust dds init` makes one, `rubicon trust dds join` takes part in one");
      !checked)
    return fail(checked.error());
  auto member = choose_member_of_island(folder, island);
  if (!member) return fail(member.error());
  const auto state = environment("STATE_DIRECTORY");  // of several the first one: `a:b`
  auto given = credential();
  Place place{folder, std::move(*member), std::move(given.key), state.substr(0, state.find(':'))};
  if (given.is_none && hidden_key(place))
    return fail(ErrorCode::kRefused, fmt::format("{}: systemd handed over no key (credential {}): `journalctl -u "
                                                 "'rubicon-trust@*'` says why",
                                                 key_of(place).string(), kCredential));
  return place;
}

std::optional<fs::path> default_folder() {
  const auto asked = environment(kVariable);
  if (asked == "no") return {};
  if (!asked.empty()) return fs::path(asked);
  // Whatever is wrong with it: an island that has trust never starts open.
  return fault_at(kHostFolder) != ENOENT ? std::optional<fs::path>(kHostFolder) : std::nullopt;
}

}  // namespace rubicon::trust
