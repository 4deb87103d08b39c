#include "trust/site/realm_members.h"

namespace rubicon::trust::site {

std::shared_ptr<const tuples::Member> member_of(const SiteRealm& realm, std::string_view user) {
  if (!realm.is_member(user) || realm.is_revoked(user)) return nullptr;
  auto member = std::make_shared<tuples::Member>();
  member->name = user;
  member->roles = realm.roles_of(user);
  member->ids.push_back({kFirstFreeId, 0xffffffff});
  for (const auto& [island, owner] : realm.islands) {
    if (owner == user) member->ids.push_back({island, island});
  }
  return member;
}

}  // namespace rubicon::trust::site
