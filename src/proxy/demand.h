#pragma once

#include <vector>

#include "proxy/liveness.h"

namespace rubicon::proxy {

/// Turns subscriptions into sampling orders. The order of a device names its wanted sensors and the shortest wanted
/// period. It is sent when it changed, at most once per turn, and again when the device or its line is back. Without
/// subscribers nothing is sampled.
class Demand {
 public:
  Demand(ProxyContext& context, DeviceDirectory& directory, TupleMirror& mirror, Liveness& liveness);

  /// Subscriptions to the value of a point changed.
  void on_demand(const tuples::Demand& demand);
  /// Sends the sampling order again, because the device may have lost it.
  void repeat(Device& device);
  /// A wanted value became stale: the device may have lost its sampling order. Sends the order now and every ten
  /// seconds until the device reports.
  void overdue(Device& device);
  /// The device's rate or its points changed.
  void changed(Device& device);
  /// Orders the device to stop sampling.
  void stop(Device& device);
  /// The device gets other keys: the subscriptions to the new keys decide what is wanted.
  static void reset(Device& device);
  /// True if the request was a Sample of ours.
  bool acknowledged(const model::Acknowledge& answer);
  void forget(const Device& device);

 private:
  void check_next_turn(Device& device);
  void check_queued();
  void repeat_overdue();
  void send_if_changed(Device& device);
  void send(Device& device);
  void note_refusal(Device& device, std::string why);
  std::chrono::milliseconds period_of(const Device& device) const;

  ProxyContext& context_;
  DeviceDirectory& directory_;
  TupleMirror& mirror_;
  Liveness& liveness_;
  base::OncePerTurn next_turn_;
  std::vector<DeviceNumber> queue_;
  std::unordered_map<std::uint64_t, DeviceNumber> requests_;  ///< at most one a device
  std::vector<DeviceNumber> busy_;                            ///< answered busy: retried after a pause
  Timer busy_timer_;
  std::vector<DeviceNumber> overdue_;
  Timer overdue_timer_;
};

}  // namespace rubicon::proxy
