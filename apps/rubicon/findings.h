#pragma once

#include <string>
#include <vector>

#include "apps/rubicon/host_network.h"
#include "rubicon/client.hpp"
#include "transport/interfaces.h"
#include "tuples/dds/dds_options.h"

namespace rubicon::cli {

/// The result of one check of `rubicon doctor`.
struct Finding {
  enum class Grade { kGood, kNote, kProblem };
  std::string check;  ///< its name, also in JSON
  Grade grade = Grade::kGood;
  std::string what;
  std::string fix{};  ///< what to do about it; member `mend` in JSON
};
std::string_view to_string(Finding::Grade grade);

using Findings = std::vector<Finding>;

// Pure functions of what was observed. Each returns findings of one check.

/// `no-multicast`: interfaces that do not exist, are down, or cannot discover others.
Findings check_interfaces(const client::Options& options, const std::vector<transport::Interface>& there);
/// `folder`: where the programs of this host meet, and who of them does not answer.
Findings check_folder(const client::HostView& view);
/// `participant-index`: no free index for one more process in the domain.
Finding check_places(std::uint32_t domain, unsigned processes);
/// `firewall`, of a peer.
Finding check_peer(const std::string& peer, std::uint32_t domain, const Probe& probe);
/// `version`: components that speak another version of the protocol.
Findings check_versions(const std::vector<client::ComponentStart>& seen, unsigned ours);
/// A warning that this program got during the check.
Finding check_complaint(const std::string& text);
/// `silent`: participants of the DDS domain that showed no component.
Findings check_silent_participants(std::size_t silent, unsigned domain);
/// `island-twice`: ids with several starts, present at the same time or one after the other.
Findings check_twins(const std::vector<client::ComponentStart>& seen);

}  // namespace rubicon::cli
