#pragma once

#include <string>

#include "rubicon/address.hpp"
#include "rubicon/result.hpp"

namespace rubicon::tuples {

// What every engine says in the same words.

/// kNotFound.
Error no_component(OwnerId id);
/// kDuplicate: this process has it.
Error already_here(OwnerId id);
/// kBusy.
Error takes_no_requests(OwnerId id);
/// Warnings about replies.
std::string unread_replies(OwnerId to);
std::string unasked_reply(OwnerId from);

}  // namespace rubicon::tuples
