#include "web/api/permission.h"

#include <fmt/format.h>

#include "rubicon/key.hpp"
#include "web/access/token_file.h"

namespace rubicon::web::api {

namespace {

std::string_view text_of(Verb verb) {
  switch (verb) {
    case Verb::kRead: return "read";
    case Verb::kWake: return "wake the sensors of";
    case Verb::kSet: return "set";
    case Verb::kSend: break;
  }
  return "send messages of type";
}

}  // namespace

Result<void> check(const Caller& caller, Verb verb, OwnerId owner, std::string_view key) {
  if (may(caller, verb, owner, key)) return {};
  return fail(ErrorCode::kRefused, fmt::format("{} has the role {}, which may not {} {}", model::quoted(caller.name),
                                               access::to_string(caller.role), text_of(verb), key));
}

}  // namespace rubicon::web::api
