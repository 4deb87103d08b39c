#include "networks/dummy/dummy_network.h"

#include <fmt/format.h>

#include <map>
#include <utility>

#include "networks/dummy/dummy_device.h"
#include "networks/dummy/dummy_sample.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::dummy {

namespace {

class DummyNetwork final : public network::Network {
 public:
  DummyNetwork(const network::NetworkConfig&, Script script, network::NetworkHost& host)
      : script_(std::move(script)), host_(host) {
    for (ScriptedDevice& device : std::exchange(script_.devices, {})) {
      std::string address = device.address;
      devices_.try_emplace(std::move(address), std::move(device), host_, up_);
    }
  }

  Result<void> open() override {
    const bool first = !std::exchange(started_, true);
    if (first) start();
    if (line_is_down(host_.scheduler().now()))
      return fail(ErrorCode::kUnreachable, "the line is down until up-at, by the configuration");
    up_ = true;
    host_.deliver({}, model::State{model::LineState::kUp, {}, {}});
    if (first) return {};
    for (auto& [address, device] : devices_) device.announce();
    return {};
  }

  /// Replaces the devices whose scripts changed; the others continue.
  Result<void> change(const network::NetworkConfig& config) override {
    Script next = read_script(config);
    if (next.seed != script_.seed || next.down_at != script_.down_at || next.up_at != script_.up_at)
      return fail(ErrorCode::kUnsupported, "seed or line changed");
    std::map<std::string, DummyDevice> before = std::exchange(devices_, {});
    for (ScriptedDevice& device : next.devices) {
      const std::string address = device.address;
      auto known = before.extract(address);
      if (known && known.mapped().has_script_of(device)) {
        devices_.insert(std::move(known));
      } else {
        DummyDevice& fresh = devices_.try_emplace(address, std::move(device), host_, up_).first->second;
        if (started_) fresh.start();
      }
    }
    for (auto& [address, device] : before) device.retire();
    return {};
  }

  Result<void> send(const Message& message) override {
    if (!up_) return fail(ErrorCode::kUnreachable, "the line is down");
    const auto found = devices_.find(message.destination.device);
    if (found == devices_.end())
      return fail(ErrorCode::kNotFound, fmt::format("no device {}", model::quoted(message.destination.device)));
    return found->second.send(message);
  }

  std::optional<std::vector<network::ListedDevice>> listed() const override {
    std::vector<network::ListedDevice> all;
    for (const auto& [address, device] : devices_) all.push_back(device.listed());
    return all;
  }

 private:
  bool line_is_down(SteadyTime now) const {
    if (!script_.down_at || now < start_time_ + *script_.down_at) return false;
    return !script_.up_at || now < start_time_ + *script_.up_at;
  }

  void start() {
    start_time_ = host_.scheduler().now();
    if (script_.down_at) down_timer_ = host_.scheduler().at(start_time_ + *script_.down_at, [this] { lose_line(); });
    for (auto& [address, device] : devices_) device.start();
  }

  void lose_line() {
    up_ = false;
    host_.failed({ErrorCode::kUnreachable, "the line is lost at down-at, by the configuration"});
  }

  Script script_;
  network::NetworkHost& host_;
  std::map<std::string, DummyDevice> devices_;
  SteadyTime start_time_{};
  bool started_ = false;
  bool up_ = false;
  Timer down_timer_;
};

}  // namespace

const network::NetworkType kType{
    .name = "dummy",
    .summary = "devices played from the configuration: waves and actuators",
    .sample_config = kSample,
    .make = network::make_network<DummyNetwork, read_script>,
    .lists_devices = true,
};

}  // namespace rubicon::networks::dummy
