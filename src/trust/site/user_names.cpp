#include "trust/site/user_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/printable.h"
#include "base/text.h"
#include "trust/member_names.h"

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
              fmt::format("`{}` is no name of a member: {}", base::one_line(name.substr(0, kLongestUser)), why));
}

}  // namespace

Result<void> check_user_name(std::string_view name) {
  if (name.empty()) return fail(ErrorCode::kInvalid, "a member needs a name: this one is empty");
  if (name.size() > kLongestUser)
    return no_name(name, fmt::format("it has {} bytes, expected at most {}", name.size(), kLongestUser));
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

}  // namespace rubicon::trust::site
