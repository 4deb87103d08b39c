#pragma once

#include <memory>
#include <string_view>

#include "base/scheduler.h"
#include "transport/transports.h"

namespace rubicon::bench::zigbee {

/// The connection of one client to a broker that costs nothing: what deliver() is given arrives at once, and what the
/// client publishes is gone.
class DirectTransports final : public transport::Transports {
 public:
  explicit DirectTransports(Scheduler& scheduler) : scheduler_(scheduler) {}

  void deliver(std::string_view topic, std::string_view payload) { callbacks_.received({topic, payload, false}); }

  Result<std::unique_ptr<transport::FileSource>> open_file(const std::string& path) override {
    return fail(ErrorCode::kNotFound, path);
  }
  Result<std::unique_ptr<transport::MqttLine>> open_mqtt(const transport::MqttOptions&,
                                                         transport::MqttCallbacks calls) override {
    callbacks_ = std::move(calls);
    scheduler_.post([this] { callbacks_.connected({}); });
    return std::make_unique<Line>();
  }

 private:
  class Line final : public transport::MqttLine {
   public:
    Result<void> subscribe(std::string_view, std::uint8_t) override { return {}; }
    Result<void> unsubscribe(std::string_view) override { return {}; }
    Result<void> publish(transport::MqttPublication) override { return {}; }
    transport::MqttCounters counters() const override { return {}; }
  };

  Scheduler& scheduler_;
  transport::MqttCallbacks callbacks_;
};

}  // namespace rubicon::bench::zigbee
