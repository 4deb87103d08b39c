#pragma once

#include <string>

#include "trust/site/site_operations.h"

namespace rubicon::trust::site {

/// What the realm and the folder know of a member.
ListedSiteMember listed_member(const SiteFolder& folder, const SiteRealm& realm, const std::string& name);

}  // namespace rubicon::trust::site
