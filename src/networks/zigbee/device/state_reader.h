#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>

#include "rubicon/result.hpp"

namespace rubicon::networks::zigbee::device {

/// One member of a state message.
struct Member {
  std::string_view key;   ///< without escapes
  std::string_view json;  ///< the text of the value as it stands in the message, without blanks around it
};

/// Reads state messages: a JSON object with any members (zigbee.md, section 5). Keeps its memory from message to
/// message.
class StateReader {
 public:
  static constexpr std::size_t kMaxPayload = std::size_t{64} * 1024, kMaxMembers = 2000;

  StateReader();
  ~StateReader();
  StateReader(const StateReader&) = delete;
  StateReader& operator=(const StateReader&) = delete;

  /// The members, in their order; valid until the next call. Values are not checked beyond their borders: who uses one
  /// parses it. kInvalid if it is no JSON object, kOutOfRange beyond the bounds.
  Result<std::span<const Member>> read(std::string_view payload);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::networks::zigbee::device
