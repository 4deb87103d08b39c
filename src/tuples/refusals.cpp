#include "tuples/refusals.h"

#include <fmt/format.h>

namespace rubicon::tuples {

Error no_component(OwnerId id) {
  return {ErrorCode::kNotFound, fmt::format("no component {} is present", number(id))};
}

Error already_here(OwnerId id) {
  return {ErrorCode::kDuplicate, fmt::format("component {} is already present in this process", number(id))};
}

Error takes_no_requests(OwnerId id) {
  return {ErrorCode::kBusy, fmt::format("component {} does not accept requests at the moment", number(id))};
}

std::string unread_replies(OwnerId to) {
  return fmt::format("component {} does not read its replies: some are dropped", number(to));
}

std::string unasked_reply(OwnerId from) {
  return fmt::format("component {} answered a request that it was not asked: ignored", number(from));
}

}  // namespace rubicon::tuples
