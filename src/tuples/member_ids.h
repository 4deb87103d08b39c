#pragma once

#include "tuples/member.h"

namespace rubicon::tuples {

/// An id for one more component of a process of the member, such as a tool or a console: a random one of its largest
/// range. It may be taken by another process of the member; then join() or Ecology::watch_displaced() tells, and the
/// caller picks again. kNoOwner: the member has no ids.
OwnerId random_id(const Member& member);

/// The ids, as texts show them: `00000007, 01a00000-01afffff`.
std::string text_of_ids(const Member& member);

}  // namespace rubicon::tuples
