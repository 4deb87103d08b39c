#include "web/caller.h"

#include <algorithm>
#include <array>

#include "base/text.h"
#include "model/message_types.h"
#include "model/point_keys.h"

namespace rubicon::web {

namespace {

std::string_view after_first_part(std::string_view key) {
  const auto dot = key.find('.');
  return dot == key.npos ? std::string_view() : key.substr(dot + 1);
}

/// Keys below the prefix of an island, whatever that is, that change how the island works; and the messages of its
/// gateway, which may say anything. Longer keys of the same branch are points of a network that has its name.
bool steers_island(std::string_view key) {
  constexpr std::array<std::string_view, 4> kBranches{"inbox", "settings", "recorder", "log"};
  constexpr auto kMostDots = 2;  // inbox.NETWORK.ADDRESS, recorder.NAME.command
  const auto first = key.substr(0, key.find('.'));
  if (first == "GATEWAY" || first == "RUBICON_GATEWAY" || model::is_line_command(key)) return true;
  const auto rest = after_first_part(key);
  const bool is_branch =
      std::find(kBranches.begin(), kBranches.end(), rest.substr(0, rest.find('.'))) != kBranches.end();
  return is_branch && std::count(rest.begin(), rest.end(), '.') <= kMostDots;
}

}  // namespace

bool may(const Caller& caller, Verb verb, OwnerId, std::string_view key) {
  switch (verb) {
    case Verb::kRead:
    case Verb::kWake: return caller.role >= Role::kView;
    case Verb::kSet: return caller.role >= (steers_island(key) ? Role::kAdmin : Role::kCommand);
    case Verb::kSend: return caller.role >= (model::is_admin_type(key) ? Role::kAdmin : Role::kCommand);
  }
  return false;
}

}  // namespace rubicon::web
