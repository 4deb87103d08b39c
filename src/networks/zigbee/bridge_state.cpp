#include "networks/zigbee/bridge_state.h"

#include <fmt/format.h>

#include <utility>

namespace rubicon::networks::zigbee {

using model::LineState;

BridgeState::BridgeState(Scheduler& scheduler, const std::string& base, std::function<void()> changed)
    : scheduler_(scheduler), base_(base), changed_(std::move(changed)) {}

void BridgeState::connected() {
  online_.reset();
  ++connections_;
  set(LineState::kConnecting, "waiting for Zigbee2MQTT");
  patience_ = scheduler_.after(kStateTime, [this] {
    set(LineState::kDown, fmt::format("Zigbee2MQTT is not there: the broker has no message on {}/bridge/state", base_));
  });
}

void BridgeState::lost(const std::string& why) {
  patience_.cancel();
  online_.reset();
  set(LineState::kDown, why);
}

Result<void> BridgeState::state(std::string_view payload, bool retained) {
  const auto online = bridge::read_online(payload);
  if (!online) return fail(online.error());
  const bool again = online_ == true && *online && scheduler_.now() - online_since_ > kRepetition;
  const bool fresh = online_ != *online;
  online_ = *online;
  if (*online) started_ = !retained;
  if (*online && (fresh || again)) online_since_ = scheduler_.now();
  if (fresh)
    decide();
  else if (again && line_ == LineState::kUp)
    changed_();
  return {};
}

void BridgeState::info(bridge::BridgeDescription info) {
  const auto version = bridge::check_version(info);
  unsupported_ = version ? std::string() : version.error().text;
  described_ = true;
  if (online_) decide();
}

void BridgeState::decide() {
  patience_.cancel();
  if (!unsupported_.empty()) return set(LineState::kRefused, unsupported_);
  if (!*online_) return set(LineState::kDown, "Zigbee2MQTT is offline");
  if (described_) return set(LineState::kUp, {});
  set(LineState::kConnecting, "waiting for bridge/info of Zigbee2MQTT");
  patience_ = scheduler_.after(kInfoTime, [this] { set(LineState::kUp, {}); });
}

void BridgeState::set(LineState line, std::string reason) {
  if (line_ == line && reason_ == reason) return;
  line_ = line;
  reason_ = std::move(reason);
  changed_();
}

}  // namespace rubicon::networks::zigbee
