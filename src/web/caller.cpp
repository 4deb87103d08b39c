#include "web/caller.h"

#include <algorithm>
#include <array>

#include "base/text.h"

namespace rubicon::web {

namespace {

std::string_view after_first_part(std::string_view key) {
  const auto dot = key.find('.');
  return dot == key.npos ? std::string_view() : key.substr(dot + 1);
}

/// Whether a key is one of these, or lies below it.
bool is_below(std::string_view key, std::string_view branch) {
  return key == branch || (key.starts_with(branch) && key[branch.size()] == '.');
}

/// Keys below the prefix of an island, whatever that is, that change how the island works; and the messages of its
/// gateway, which may say anything.
bool steers_island(std::string_view key) {
  constexpr std::array<std::string_view, 4> kBranches{"inbox", "settings", "recorder", "log"};
  if (key == "GATEWAY") return true;
  const auto rest = after_first_part(key);
  return std::any_of(kBranches.begin(), kBranches.end(), [rest](auto branch) { return is_below(rest, branch); });
}

}  // namespace

bool may(const Caller& caller, Verb verb, OwnerId, std::string_view key) {
  switch (verb) {
    case Verb::kRead:
    case Verb::kWake: return caller.role >= Role::kView;
    case Verb::kSet: return caller.role >= (steers_island(key) ? Role::kAdmin : Role::kCommand);
    case Verb::kSend: return caller.role >= Role::kCommand;
  }
  return false;
}

}  // namespace rubicon::web
