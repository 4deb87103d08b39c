#pragma once

#include "tuples/member.h"

namespace rubicon::trust {

/// A random id of the member's block, which tools and consoles take. kNoOwner: its certificate has ids of islands only.
OwnerId random_id(const tuples::Member& member);

/// `7, 01a00000-01afffff`: islands by their numbers, blocks in hexadecimal digits.
std::string ids_text(const tuples::Member& member);

}  // namespace rubicon::trust
