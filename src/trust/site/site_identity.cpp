#include "trust/site/site_identity.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>

#include "base/text.h"
#include "trust/member_names.h"
#include "trust/site/site_folder.h"

namespace rubicon::trust::site {

namespace {

using Reason = std::pair<char, std::string_view>;

constexpr std::array<Reason, 6> kReasons{{
    {'/', "`/` begins another level of a topic, and the broker's rights by user would not hold"},
    {'+', "`+` stands for any level of a topic, and brokers deny such a user everything"},
    {'#', "`#` stands for all levels of a topic, and brokers deny such a user everything"},
    {':', "`:` separates a name from its source in rights, and the user from the password in files"},
    {'@', "`@` separates a person from the member who vouches for it"},
    {' ', "a blank ends a name in access lists of brokers"},
}};

constexpr std::string_view kWords = "it means something else in rights";
constexpr std::string_view kTopics = "it means something else in topics and rights";

constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kTaken{{
    {"-", "it is how topics spell a user without a name"},
    {"-probe-", "it is in whose name members try whether the broker protects topics"},
    {"peis", kTopics},
    {"lan", kTopics},
    {"everybody", kWords},
    {"all", kWords},
    {"admin", kWords},
}};

constexpr std::string_view kIslandUser = "island-";

tl::unexpected<Error> no_name(std::string_view name, std::string_view why) {
  return fail(ErrorCode::kInvalid,
              fmt::format("`{}` is not a name of a member: {}", base::one_line(name.substr(0, kMaxUserLength)), why));
}

}  // namespace

Result<void> check_user_name(std::string_view name) {
  if (name.empty()) return fail(ErrorCode::kInvalid, "a member needs a name: this one is empty");
  if (name.size() > kMaxUserLength)
    return no_name(name, fmt::format("it has {} bytes, expected at most {}", name.size(), kMaxUserLength));
  for (const auto& [taken, why] : kTaken) {
    if (name == taken) return no_name(name, why);
  }
  for (const auto& [character, why] : kReasons) {
    if (name.find(character) != name.npos) return no_name(name, why);
  }
  return check_member_name(name);
}

Result<void> check_island_of(std::string_view name, const std::vector<OwnerId>& islands) {
  if (!name.starts_with(kIslandUser)) return {};
  const auto number = base::parse_number<std::uint32_t>(name.substr(kIslandUser.size()));
  if (!number) return {};
  if (std::find(islands.begin(), islands.end(), OwnerId{*number}) != islands.end()) return {};
  return no_name(name, fmt::format("where a broker has no realm it is island {0}: expected --island {0}", *number));
}

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
