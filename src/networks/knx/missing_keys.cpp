#include "networks/knx/missing_keys.h"

#include <fmt/format.h>

#include <algorithm>

namespace rubicon::networks::knx {

namespace {

constexpr std::size_t kNamed = 5;

/// `1/2/7, 1/2/8 and 3 more`.
std::string list_of(const std::vector<wire::GroupAddress>& groups) {
  std::string out;
  const auto named = groups.size() <= kNamed ? groups.size() : kNamed - 1;
  for (std::size_t i = 0; i < named; ++i) out += fmt::format("{}{}", i == 0 ? "" : ", ", to_string(groups[i]));
  return named == groups.size() ? out : fmt::format("{} and {} more", out, groups.size() - named);
}

}  // namespace

std::vector<wire::GroupAddress> add_without_keys(secure::GroupKeys& keys,
                                                 const std::vector<wire::GroupAddress>& secured) {
  std::vector<wire::GroupAddress> added;
  for (const auto group : secured) {
    if (keys.groups.try_emplace(group).second) added.push_back(group);
  }
  return added;
}

std::string explain_missing_keys(const std::vector<wire::GroupAddress>& groups, const SecureOptions& options) {
  if (groups.empty()) return {};
  const bool one = groups.size() == 1;
  return fmt::format("there {} for the secured group{} {}: nothing is sent to {} or taken from {}; {}",
                     one ? "is no key" : "are no keys", one ? "" : "s", list_of(groups), one ? "it" : "them",
                     one ? "it" : "them",
                     options.keyring      ? "export the keyring of the whole project from ETS again"
                     : options.group_keys ? "add them to the file of `group-keys-file`, or configure a `keyring` of ETS"
                                          : "export a keyring from ETS and configure `keyring`");
}

void add_missing_keys(const SecureOptions& secure, const LineOptions& line,
                      const std::vector<wire::GroupAddress>& secured, bool remembers,
                      std::vector<network::Missing>& all) {
  auto access = derive_access(secure, line);
  using Kind = network::Missing::Kind;
  if (!access)
    return all.push_back({secure.keyring ? "keyring" : "secure", access.error().text,
                          access.error().code == ErrorCode::kIo ? Kind::kOnHost : Kind::kWrong});
  if (!access->groups.groups.empty() && !remembers)
    all.push_back({secure.keyring ? "keyring" : "group-keys-file",
                   "its groups can only be read, and recorded telegrams are taken once more after each start: sequence "
                   "numbers need a state file (state: {file: ...})",
                   Kind::kWarning});
  if (access->routing && !remembers)
    all.push_back({secure.keyring ? "keyring" : "backbone-key-file",
                   "recorded telegrams of secure routing can be replayed after a restart: its timer needs a state file "
                   "(state: {file: ...})",
                   Kind::kWarning});
  const auto without = add_without_keys(access->groups, secured);
  if (!without.empty())
    all.push_back({secure.keyring ? "keyring" : "import", explain_missing_keys(without, secure), Kind::kWarning});
}

}  // namespace rubicon::networks::knx
