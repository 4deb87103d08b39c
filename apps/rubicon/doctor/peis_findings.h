#pragma once

#include <set>
#include <string_view>
#include <vector>

#include "apps/rubicon/doctor/findings.h"
#include "apps/rubicon/doctor/island_findings.h"

namespace rubicon::cli {

// Pure functions of what was observed on a PEIS network. Each returns findings of one check.

/// `peis-port`: whether this program found a port to listen on.
Finding check_peis_port(const client::PeisView& view, const client::Options& options);
/// `peis-components`: how many kernels and components of ours are there, or what to do if there are none.
Finding check_peis_components(const std::vector<client::Component>& components, const client::Options& options);
/// `peis-network`, `version`, `id-twice`, `unreachable`: programs with which no tuples can be exchanged. If the
/// component is present through another one, the finding is only a note.
Findings check_peis_troubles(const client::PeisView& view, const client::Options& options,
                             const std::vector<client::Component>& components);
/// `unknown-id`: ids that the tuples of a kernel name (meta tuples, `kernel.subscribers`) and that no component has.
Findings check_peis_ids(const std::vector<client::Tuple>& of_kernels, const std::set<OwnerId>& present);
/// `peis`: what an island does not do for components on PEIS, and why: its counters `peis-...`.
Findings check_peis_counters(const IslandSeen& seen);

/// Whether check_peis_counters() explains the counter.
bool is_peis_counter(std::string_view name);
/// Whether the component is a kernel, or another program that is not ours.
bool is_kernel(const client::Component& component);

}  // namespace rubicon::cli
