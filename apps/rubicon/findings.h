#pragma once

#include <string>
#include <vector>

#include "apps/rubicon/host_network.h"
#include "rubicon/client.hpp"
#include "transport/interfaces.h"
#include "tuples/dds/dds_options.h"

namespace rubicon::cli {

/// One thing that `rubicon doctor` looked at.
struct Finding {
  enum class Grade { kGood, kNote, kProblem };
  std::string check;  ///< its name, for programs too
  Grade grade = Grade::kGood;
  std::string what;
  std::string mend{};  ///< what to do about it
};
std::string_view to_string(Finding::Grade grade);

using Findings = std::vector<Finding>;

// Pure: what follows from what was seen. Each gives one finding or more of one name.

/// `no-multicast`: interfaces that are not there, are down, or cannot find others.
Findings check_interfaces(const client::Options& options, const std::vector<transport::Interface>& there);
/// `participant-index`: no place for one more process in the domain.
Finding check_places(std::uint32_t domain, unsigned processes);
/// `firewall`, of a peer.
Finding check_peer(const std::string& peer, std::uint32_t domain, const Probe& probe);
/// `version`: components that speak another version of the protocol.
Findings check_versions(const std::vector<client::ComponentStart>& seen, unsigned ours);
/// `island-twice`: ids with two starts that are there at the same time, or that came and went.
Findings check_twins(const std::vector<client::ComponentStart>& seen);

}  // namespace rubicon::cli
