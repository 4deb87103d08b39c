#pragma once

#include <string>
#include <vector>

#include "base/scheduler.h"
#include "rubicon/result.hpp"
#include "tuples/dds/dds_options.h"

namespace rubicon::tuples::dds {

/// A network interface of this host.
struct Interface {
  std::string name;
  std::string address;  ///< IPv4; empty = none
  bool is_up = false;
  bool has_multicast = false;
};

/// All there are now.
std::vector<Interface> interfaces();

/// kIo: one of options.interfaces is absent, down, without address, or cannot find the others; with what to do about
/// it.
Result<void> check_interfaces(const DdsOptions& options, const std::vector<Interface>& there);

/// Names of hosts (also before `:port`) become their first IPv4 addresses. What cannot be resolved stays as it is and
/// is put into `unknown`. Asks the resolver of the system, which may take some seconds: those that are left after
/// `patience` are unknown.
std::vector<std::string> with_addresses(std::vector<std::string> peers, Scheduler& scheduler, Duration patience,
                                        std::vector<std::string>& unknown);
bool has_address(const std::string& peer);

/// The same for all processes that share a kernel's boot and a network namespace, unlike for all others; 16 hex
/// digits. Of two with another `purpose` one cannot be told from the other.
std::string host_id(const std::string& purpose);

}  // namespace rubicon::tuples::dds
