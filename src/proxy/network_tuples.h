#pragma once

#include <set>
#include <string>

#include "base/scheduler.h"
#include "proxy/device_directory.h"

namespace rubicon::proxy {

/// Publishes the tuples of networks and of the island: line, counters, reachable devices, list of networks. The device
/// list of a network is published at most four times a second, that of the island at most once.
class NetworkTuples {
 public:
  NetworkTuples(ProxyContext& context, DeviceDirectory& directory);

  /// The island's own tuples and those of the configured networks.
  void begin();
  /// Publishes the tuples of a new network; does nothing for a known one.
  void declare(Network& network);
  /// Erases the tuples of a network.
  void remove(Network& network);
  /// Networks were added or removed.
  void networks_changed();
  void line_changed(Network& network);
  void devices_changed(Network& network);
  /// Publishes the changed counters of all networks, their queues and devices; at most once a second.
  void refresh_counters();

 private:
  void list_soon();
  void publish_networks();
  void publish_devices();
  void publish_all_devices();
  void publish_list(TupleRef tuple, const std::string& key, const std::string& list);
  void publish_counters();
  void publish_property(Network& network, const std::string& name, std::string value);

  ProxyContext& context_;
  DeviceDirectory& directory_;
  TupleRef all_devices_tuple_;
  std::string all_devices_;         ///< as last published, or refused
  std::set<std::string> too_long_;  ///< keys of the lists that do not fit and were reported
  base::PacedCall publish_devices_, publish_all_devices_, publish_counters_;
};

}  // namespace rubicon::proxy
