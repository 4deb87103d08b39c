#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/time.h"

namespace rubicon::tuples::dds {

/// How components find each other.
struct DdsOptions {
  std::uint32_t domain = 0;                        ///< 0..230: who has another one is not there
  std::vector<std::string> interfaces = {"lo"};    ///< names; more than loopback = other hosts may come
  std::vector<std::string> peers;                  ///< addresses of hosts, where multicast does not reach them
  std::string tag;                                 ///< who has another one is not there, in the same domain too
  base::Duration lease = std::chrono::seconds(2);  ///< silence after which a component is lost

  friend bool operator==(const DdsOptions&, const DdsOptions&) = default;
};

/// Nothing leaves this host.
bool is_loopback_only(const DdsOptions& options);

/// Cyclone's own configuration of the domain (https://cdds.io/config).
std::string domain_xml(const DdsOptions& options);

}  // namespace rubicon::tuples::dds
