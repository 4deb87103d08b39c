#include "trust/site/site_place.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

#include "trust/site/site_folder.h"

namespace rubicon::trust::site {

namespace {

namespace fs = std::filesystem;

constexpr const char* kRealmVariable = "RUBICON_REALM";

std::string_view variable_text(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string_view() : value;
}

/// Nobody should act as a member by a key that others may have copied.
Result<void> check_key_access(const std::string& path) {
  struct stat about {};
  if (::stat(path.c_str(), &about) != 0 || (about.st_mode & (S_IRWXO | S_IWGRP)) == 0) return {};
  return fail(ErrorCode::kRefused,
              fmt::format("{}: others may use this key: expected the mode 0600; run chmod 600 as its owner", path));
}

SitePlace place_of(const fs::path& folder, const std::string& user) {
  const auto state = variable_text("STATE_DIRECTORY");  // of several the first one: `a:b`
  return {folder, user, fs::path(state.substr(0, state.find(':')))};
}

std::string secret_of(const SitePlace& place) {
  return place.has_password() ? place.password() : place.key();
}

bool may_read(const std::string& path) {
  return ::faccessat(AT_FDCWD, path.c_str(), R_OK, AT_EACCESS) == 0;
}

Result<SitePlace> checked_place(SitePlace place) {
  if (auto safe = check_key_access(secret_of(place)); !safe) return fail(safe.error());
  return place;
}

Result<SiteRealm> realm_in(const SiteFolder& folder, WallTime now) {
  const auto authority = folder.authority(now);
  if (!authority) return fail(authority.error());
  return folder.realm(*authority);
}

std::vector<std::string> usable_members(const SiteFolder& folder, const SiteRealm& realm, const fs::path& root) {
  auto names = folder.members();
  std::erase_if(names, [&](const std::string& user) {
    return realm.is_revoked(user) || !may_read(secret_of(place_of(root, user)));
  });
  return names;
}

bool is_of_island(const SiteRealm& realm, const std::string& user) {
  return std::any_of(realm.islands.begin(), realm.islands.end(), [&](const auto& one) { return one.second == user; });
}

}  // namespace

std::string SitePlace::authority() const {
  return (folder / kAuthorityFile).string();
}

std::string SitePlace::certificate() const {
  return (folder / member_certificate(user)).string();
}

std::string SitePlace::key() const {
  return (folder / member_key(user)).string();
}

std::string SitePlace::password() const {
  return (folder / member_password(user)).string();
}

bool SitePlace::has_password() const {
  std::error_code error;
  return fs::exists(password(), error);
}

fs::path own_site_folder() {
  const auto home = variable_text("HOME");
  return home.empty() ? fs::path() : fs::path(home) / ".config/rubicon/realm";
}

std::optional<fs::path> site_folder_of_user() {
  const auto asked = variable_text(kRealmVariable);
  if (asked == "no") return {};
  if (!asked.empty()) return fs::path(asked);
  for (const auto& folder : {own_site_folder(), fs::path(kHostSiteFolder)}) {
    if (!folder.empty() && SiteFolder(folder).has_realm()) return folder;
  }
  return {};
}

Result<SitePlace> site_place_of_island(const fs::path& folder, OwnerId island, WallTime now) {
  const SiteFolder opened(folder);
  const auto realm = realm_in(opened, now);
  if (!realm) return fail(realm.error());
  const auto id = model::number(island);
  const auto* user = realm->member_of(island);
  if (user == nullptr)
    return fail(ErrorCode::kNotFound,
                fmt::format("{}: the realm names no member for island {}: `rubicon trust add NAME --island {}` on the "
                            "host with the authority, `rubicon trust join` here",
                            folder.string(), id, id));
  auto place = place_of(folder, *user);
  std::error_code error;
  if (!fs::exists(secret_of(place), error))
    return fail(ErrorCode::kNotFound, fmt::format("{}: is not here: island {} is the member {}, whose file "
                                                  "`rubicon trust join` takes",
                                                  secret_of(place), id, *user));
  return checked_place(std::move(place));
}

Result<SitePlace> site_place_of_people(const fs::path& folder, WallTime now) {
  const SiteFolder opened(folder);
  const auto realm = realm_in(opened, now);
  if (!realm) return fail(realm.error());
  auto names = usable_members(opened, *realm, folder);
  const bool has_people =
      std::any_of(names.begin(), names.end(), [&](const auto& user) { return !is_of_island(*realm, user); });
  if (has_people) std::erase_if(names, [&](const auto& user) { return is_of_island(*realm, user); });
  if (names.size() == 1) return checked_place(place_of(folder, names.front()));
  if (names.empty())
    return fail(ErrorCode::kNotFound,
                fmt::format("{}: has no member whose key this user may read: `rubicon trust join` "
                            "takes one of your own",
                            folder.string()));
  return fail(ErrorCode::kDuplicate,
              fmt::format("{}: has the members {}: expected one", folder.string(), fmt::join(names, ", ")));
}

}  // namespace rubicon::trust::site
