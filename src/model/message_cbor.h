#pragma once

#include <string_view>

#include "base/bytes.h"
#include "model/message.h"
#include "rubicon/result.hpp"

namespace rubicon::model {

/// The media type of messages in GATEWAY tuples.
inline constexpr std::string_view kMessageMediaType = "application/rubicon+cbor";

/// True also for D1.4's spelling `rubicon/application` and the original's `application/rubicon`.
bool is_message_media_type(std::string_view media_type);

/// Largest encoded message and most entries in each of its lists.
inline constexpr std::size_t kMaxMessageBytes = 256UL * 1024;
inline constexpr std::size_t kMaxMessageEntries = 4096;

/// The CBOR form of docs/gateway.cddl. Types travel as number and, where the message has it, as name.
Bytes to_cbor(const Message& message);

/// kInvalid says which field is wrong and what was expected; kOutOfRange for a message beyond the bounds. Keys it does
/// not know are ignored, so that newer islands can say more.
Result<Message> from_cbor(ByteView bytes);

}  // namespace rubicon::model
