#include "networks/zigbee/zigbee_network.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "networks/zigbee/zigbee_options.h"
#include "networks/zigbee/zigbee_sample.h"

namespace rubicon::networks::zigbee {

namespace {

class ZigbeeNetwork final : public network::Network {
 public:
  ZigbeeNetwork(const network::NetworkConfig&, ZigbeeOptions options, network::NetworkHost&)
      : options_(std::move(options)) {}

  Result<void> open() override {
    return fail(ErrorCode::kUnsupported, fmt::format("no MQTT line to {}", options_.broker.host));
  }
  Result<void> send(const Message& message) override {
    return fail(ErrorCode::kUnsupported, fmt::format("ZigBee does not support {}", to_string(message.kind())));
  }

 private:
  ZigbeeOptions options_;
};

}  // namespace

const network::NetworkType kType{
    .name = "zigbee",
    .summary = "ZigBee devices, through Zigbee2MQTT and its MQTT broker",
    .sample_config = kSample,
    .make = network::make_network<ZigbeeNetwork, read_zigbee_options>,
    .quiet = true,
    .answer_time = std::chrono::seconds(30),  // a sleeping device takes a command when it wakes
};

}  // namespace rubicon::networks::zigbee
