#pragma once

#include <vector>

#include "proxy/liveness.h"

namespace rubicon::proxy {

/// Turns subscriptions into sampling: per device one set of sensors and the shortest wanted period, sent when it
/// changed, at most once a turn; sent again when the device or its line comes back. Nobody listens: nothing is sampled.
class Demand {
 public:
  Demand(ProxyContext& context, DeviceDirectory& directory, TupleMirror& mirror, Liveness& liveness);

  /// The space tells who is wanted.
  void wanted(const tuples::Demand& demand);
  /// The device may have forgotten what it was told.
  void repeat(Device& device);
  /// A sensor that is wanted has not been heard in time: the device may have lost what it was told. Told again now and
  /// every ten seconds until it reports.
  void overdue(Device& device);
  /// The device's rate or its points changed.
  void changed(Device& device);
  /// Nothing is wanted of the device from now on, and it is told so.
  void stop(Device& device);
  /// True if the request was a Sample of ours.
  bool acknowledged(const model::Acknowledge& answer);
  void forget(const Device& device);

 private:
  void ask(Device& device);
  void flush();
  void tell_overdue();
  void tell(Device& device);
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
  std::vector<DeviceNumber> busy_;                            ///< to be told again after a pause
  Timer busy_timer_;
  std::vector<DeviceNumber> overdue_;
  Timer overdue_timer_;
};

}  // namespace rubicon::proxy
