#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "rubicon/result.hpp"
#include "transport/transports.h"

namespace rubicon::zigbee_simulator {

/// A recorded message of a bridge.
struct RecordedMessage {
  Duration at{};      ///< since the first one
  std::string topic;  ///< without the base
  std::string payload;
};

/// Reads a trace as `mosquitto_sub -F '%J'` writes it: a JSON object with tst, topic and payload on each line. What
/// clients published (set, get, bridge/request) is left out. kInvalid names the line.
Result<std::vector<RecordedMessage>> read_trace(std::string_view text);

/// Publishes the messages of a trace at their times, to another base. States of the bridge, its lists and availability
/// are retained, as a bridge does.
class Replay {
 public:
  struct Options {
    std::string base = "zigbee2mqtt";
    transport::MqttOptions broker;
    double speed = 1;  ///< times faster; 0 = at once
  };

  /// Scheduler, transports and log must outlive it. `done` is called once: the trace has ended, or the broker is lost.
  Replay(Options options, std::vector<RecordedMessage> messages, Scheduler& scheduler,
         transport::Transports& transports, Log log, std::function<void(Result<void>)> done);

  /// Begins to connect, again each second until the broker is there.
  Result<void> open();
  std::function<void()> started;  ///< the first message is due
  std::size_t published() const { return next_; }

 private:
  void failed(const Error& why);
  void resume();
  bool send(const RecordedMessage& message);
  SteadyTime due_time(Duration at) const;

  Options options_;
  std::vector<RecordedMessage> messages_;
  Scheduler& scheduler_;
  transport::Transports& transports_;
  Log log_;
  std::function<void(Result<void>)> done_;
  std::unique_ptr<transport::MqttLine> line_;
  SteadyTime began_{};
  std::size_t next_ = 0;
  bool connected_ = false;
  Timer timer_;
};

}  // namespace rubicon::zigbee_simulator
