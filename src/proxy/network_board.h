#pragma once

#include <string>

#include "proxy/device_directory.h"

namespace rubicon::proxy {

/// Keeps the tuples of networks and of the island: line, counters, reachable devices, list of networks. However fast
/// devices come and go, their lists (of a network, of the island) are published at most four times a second.
class NetworkBoard {
 public:
  NetworkBoard(Surroundings& around, DeviceDirectory& directory);

  /// The island's own tuples and those of the configured networks.
  void begin();
  /// Makes the tuples of a network that appeared.
  void declare(Network& network);
  /// Takes the tuples of a network away.
  void remove(Network& network);
  /// Networks came or went.
  void networks_changed();
  void line_changed(Network& network);
  void devices_changed(Network& network);
  /// Counters of the network, of its queue and of its devices, as far as they changed; at most once a second.
  void refresh_counters();

 private:
  void list_soon();
  void publish_networks();
  void publish_devices();
  void publish_counters();
  void publish_property(Network& network, const std::string& name, std::string value);

  Surroundings& around_;
  DeviceDirectory& directory_;
  Timer devices_timer_, counters_timer_;
  SteadyTime devices_at_{}, counters_at_{};  ///< not again before
};

}  // namespace rubicon::proxy
