#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>

#include "transport/mqtt.h"

namespace rubicon::transport {

/// Publications that wait for a busy line, within the bounds of MqttLine. A message of kind kLatest replaces the one of
/// its topic that waits, in its place; all others keep their order.
class MqttOutQueue {
 public:
  /// kBusy beyond the bounds.
  Result<void> push(MqttPublication publication, const std::string& line);
  /// The oldest; nullopt if none waits.
  std::optional<MqttPublication> pop();
  bool empty() const { return waiting_.empty(); }
  std::size_t size() const { return waiting_.size(); }
  std::size_t bytes() const { return bytes_; }

 private:
  std::deque<MqttPublication> waiting_;
  std::map<std::string, std::uint64_t, std::less<>> latest_;  ///< topic -> number of its publication that waits
  std::uint64_t first_ = 0;                                   ///< number of waiting_.front()
  std::size_t bytes_ = 0;
};

}  // namespace rubicon::transport
