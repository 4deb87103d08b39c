#pragma once

#include <memory>

#include "base/scheduler.h"
#include "transport/mqtt.h"

namespace rubicon::transport {

class MqttHome;

/// MQTT lines on libmosquitto, each with a thread of its own: the library blocks while it looks a name up and connects,
/// and takes longer in one call than a loop may stop. Must be destroyed before the loop, and after the lines.
class MosquittoLines {
 public:
  /// The scheduler must accept calls from other threads.
  explicit MosquittoLines(Scheduler& scheduler);
  /// Waits up to a second for connections of destroyed lines, until they are closed in order.
  ~MosquittoLines();
  MosquittoLines(const MosquittoLines&) = delete;
  MosquittoLines& operator=(const MosquittoLines&) = delete;

  /// As Transports::open_mqtt.
  Result<std::unique_ptr<MqttLine>> open(const MqttOptions& options, MqttCalls calls);

 private:
  Scheduler& scheduler_;
  std::shared_ptr<MqttHome> home_;
};

}  // namespace rubicon::transport
