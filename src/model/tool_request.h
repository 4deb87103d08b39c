#pragma once

#include <nlohmann/json.hpp>

#include "model/message.h"
#include "rubicon/result.hpp"

namespace rubicon::model {

/// Longest request of a tool to a network, in bytes. Networks refuse longer ones; the audit reads all others.
inline constexpr std::size_t kMaxToolRequest = 64UL * 1024;

/// The JSON object of a request of a tool, such as `knx.request`; kInvalid if it is longer or no object.
Result<nlohmann::json> read_tool_request(const Opaque& request);

}  // namespace rubicon::model
