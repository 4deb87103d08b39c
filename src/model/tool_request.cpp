#include "model/tool_request.h"

#include <fmt/format.h>

#include "model/json_text.h"

namespace rubicon::model {

Result<nlohmann::json> read_tool_request(const Opaque& request) {
  if (request.bytes.size() > kMaxToolRequest)
    return fail(ErrorCode::kInvalid, fmt::format("a {} of {} bytes, expected at most {}", request.type,
                                                 request.bytes.size(), kMaxToolRequest));
  auto object = parse_json(base::as_text(request.bytes));
  if (!object.is_object()) return fail(ErrorCode::kInvalid, fmt::format("a {} is a JSON object", request.type));
  return object;
}

}  // namespace rubicon::model
