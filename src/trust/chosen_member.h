#pragma once

#include <filesystem>
#include <string>

#include "rubicon/address.hpp"
#include "rubicon/result.hpp"

namespace rubicon::trust {

// Which member of a folder a process is. A revoked one is chosen only if there is no other: Trust::open() says then
// that it was revoked. A certificate that cannot be read is no reason against the others.

/// Of those with the id of the island: not revoked comes first, then with a key here, then the latest end. kNotFound:
/// there is none.
Result<std::string> choose_member_of_island(const std::filesystem::path& folder, OwnerId island);
/// `local`, else the only one that is no island's and whose key is here: one that the people of the host may read, else
/// any. kNotFound: there is none. kDuplicate: there are two.
Result<std::string> choose_member_of_people(const std::filesystem::path& folder);

}  // namespace rubicon::trust
