#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "base/scheduler.h"
#include "model/message.h"
#include "networks/zigbee/bridge/messages.h"

namespace rubicon::networks::zigbee {

/// Whether Zigbee2MQTT is there and can be used: what `bridge/state` and `bridge/info` say on a connection to the
/// broker (zigbee.md, section 2).
class BridgeState {
 public:
  /// How long the retained `bridge/state` may take after a connect, and `bridge/info` after `online`. A broker that
  /// was restarted without persistence has no `bridge/info`.
  static constexpr Duration kStateTime = std::chrono::seconds(5), kInfoTime = std::chrono::seconds(2);
  /// Two messages `online` within this time are one that arrived twice (QoS 1).
  static constexpr Duration kRepetition = std::chrono::seconds(1);

  /// `changed` is called at each change, and when the bridge was started again without having been offline.
  BridgeState(Scheduler& scheduler, const std::string& base, std::function<void()> changed);

  void connected();
  void lost(const std::string& why);
  /// A payload of `bridge/state`. `retained`: the broker kept it, so the bridge did not start just now.
  Result<void> state(std::string_view payload, bool retained);
  /// Whether the bridge or the broker was started again: old states may be published as if they were new.
  bool repeats() const { return started_ || connections_ > 1; }
  void info(bridge::BridgeDescription info);

  model::LineState line() const { return line_; }
  /// Why it is not up; empty = it is.
  const std::string& reason() const { return reason_; }
  /// False after a bridge/info of a version that we do not speak.
  bool supported() const { return unsupported_.empty(); }

 private:
  void decide();
  void set(model::LineState line, std::string reason);

  Scheduler& scheduler_;
  std::string base_;
  std::function<void()> changed_;
  model::LineState line_ = model::LineState::kConnecting;
  std::string reason_;
  std::optional<bool> online_;  ///< nullopt: not received on this connection
  SteadyTime online_since_{};
  bool started_ = false;  ///< the last `online` came live
  unsigned connections_ = 0;
  bool described_ = false;  ///< bridge/info came, on this connection or an earlier one
  std::string unsupported_;
  Timer patience_;
};

}  // namespace rubicon::networks::zigbee
