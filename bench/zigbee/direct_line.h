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

  void deliver(std::string_view topic, std::string_view payload) { calls_.received({topic, payload, false}); }

  Result<std::unique_ptr<transport::FileSource>> open_file(const std::string& path) override {
    return fail(ErrorCode::kNotFound, path);
  }
  Result<std::unique_ptr<transport::MqttLine>> open_mqtt(const transport::MqttOptions&,
                                                         transport::MqttCalls calls) override {
    calls_ = std::move(calls);
    scheduler_.post([this] { calls_.connected({}); });
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
  transport::MqttCalls calls_;
};

}  // namespace rubicon::bench::zigbee
