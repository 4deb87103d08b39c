#pragma once

#include <string_view>

#include "rubicon/result.hpp"
#include "web/caller.h"

namespace rubicon::web::api {

/// kRefused, with the reason, if may() does not permit it.
Result<void> check(const Caller& caller, Verb verb, OwnerId owner, std::string_view key);

}  // namespace rubicon::web::api
