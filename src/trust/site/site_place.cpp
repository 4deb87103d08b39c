#include "trust/site/site_place.h"

#include <cstdlib>

#include "trust/site/site_folder.h"

namespace rubicon::trust::site {

namespace {

namespace fs = std::filesystem;

std::string_view variable_text(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string_view() : value;
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

std::optional<SitePlace> site_place_beside(const std::string& ca_file, const std::string& user) {
  const auto folder = fs::path(ca_file).parent_path();
  std::error_code error;
  if (ca_file.empty() || !fs::exists(folder / kRealmFile, error)) return {};
  const auto state = variable_text("STATE_DIRECTORY");  // of several the first one: `a:b`
  return SitePlace{folder, user, fs::path(state.substr(0, state.find(':')))};
}

}  // namespace rubicon::trust::site
