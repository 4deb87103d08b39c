#pragma once

#include <memory>
#include <string_view>

#include "trust/site/site_realm.h"
#include "tuples/member.h"

namespace rubicon::trust::site {

/// Ids from here on are free to every member; one below is that of an island.
inline constexpr std::uint32_t kFirstFreeId = 65536;

/// Who a user of the broker is: its roles, and the ids that it may use. nullptr: no member of the realm, or shut out.
std::shared_ptr<const tuples::Member> member_of(const SiteRealm& realm, std::string_view user);

}  // namespace rubicon::trust::site
