#include "apps/rubicon/findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "apps/rubicon/island_findings.h"
#include "apps/rubicon/table.h"

namespace rubicon::cli {

namespace {

using Grade = Finding::Grade;

constexpr const char* kMulticast = "no-multicast";
constexpr const char* kTwins = "island-twice";
constexpr const char* kVersion = "version";

bool only_loopback(const client::Options& options) {
  return std::all_of(options.interfaces.begin(), options.interfaces.end(), [](const auto& one) { return one == "lo"; });
}

std::string names_of(const std::vector<transport::Interface>& there) {
  std::string names;
  for (const auto& one : there) names += (names.empty() ? "" : ", ") + one.name;
  return names;
}

Finding check_interface(const std::string& name, bool needs_multicast, const std::vector<transport::Interface>& there) {
  const auto found = std::find_if(there.begin(), there.end(), [&](const auto& one) { return one.name == name; });
  if (found == there.end())
    return {"interface", Grade::kProblem, fmt::format("{} is not an interface of this host", name),
            fmt::format("--interfaces takes: {}", names_of(there))};
  if (!found->is_up)
    return {"interface", Grade::kProblem, fmt::format("{} is down", name), fmt::format("ip link set {} up", name)};
  if (found->address.empty())
    return {"interface", Grade::kProblem, fmt::format("{} has no IPv4 address", name),
            fmt::format("ip address add ADDRESS/24 dev {}, or wait for DHCP", name)};
  if (needs_multicast && !found->has_multicast)
    return {kMulticast, Grade::kProblem,
            fmt::format("{} ({}) has no multicast: components there cannot discover each other", name, found->address),
            fmt::format("name the other hosts (--peers, tuples.peers), or: ip link set {} multicast on", name)};
  return {"interface", Grade::kGood, fmt::format("{} ({}) is up", name, found->address)};
}

std::string who(const client::ComponentStart& one) {
  auto text = one.summary.host.empty() ? std::string("an unknown host") : one.summary.host;
  if (!one.summary.program.empty()) text += " (" + one.summary.program + ")";
  return text;
}

}  // namespace

std::string_view to_string(Finding::Grade grade) {
  switch (grade) {
    case Grade::kGood: return "good";
    case Grade::kNote: return "note";
    case Grade::kProblem: return "problem";
  }
  return "good";
}

Findings check_folder(const client::HostView& view) {
  Findings all{
      {"folder", Grade::kGood, fmt::format("programs of this host meet in {}, space {}", view.folder, view.space)}};
  for (const auto& who : view.awaited)
    all.push_back({"folder", Grade::kProblem, fmt::format("{} does not say who it is", who),
                   "it hangs or is stopped: look at it, for example with `ps`"});
  return all;
}

Findings check_interfaces(const client::Options& options, const std::vector<transport::Interface>& there) {
  Findings all;
  const bool needs_multicast = !only_loopback(options) && options.peers.empty();
  for (const auto& name : options.interfaces) all.push_back(check_interface(name, needs_multicast, there));
  return all;
}

Finding check_places(std::uint32_t domain, unsigned processes) {
  if (processes >= tuples::dds::kMaxProcessesPerHost)
    return {"participant-index", Grade::kProblem,
            fmt::format("all {} participant indexes of this host in domain {} are in use",
                        tuples::dds::kMaxProcessesPerHost, domain),
            "end programs that are not needed (`ss -lunp` lists them), or give some islands another tuples.domain"};
  return {"participant-index", Grade::kGood,
          fmt::format("{} of {} participant indexes of this host in domain {} are in use", processes,
                      tuples::dds::kMaxProcessesPerHost, domain)};
}

Finding check_peer(const std::string& peer, std::uint32_t domain, const Probe& probe) {
  const auto ports =
      fmt::format("{} to {}", tuples::dds::multicast_port_of(domain), tuples::dds::multicast_port_of(domain + 1) - 1);
  if (!probe.error.empty())
    return {"firewall", Grade::kProblem, fmt::format("cannot send to peer {}: {}", peer, probe.error),
            fmt::format("check the routes (`ip route get {}`) and the rules for outgoing UDP on this host", peer)};
  if (probe.silent > 0 && !probe.closed_port_refused)
    return {"firewall", Grade::kProblem,
            fmt::format("peer {} does not answer to UDP: it is off, or a firewall drops the datagrams", peer),
            fmt::format("allow UDP ports {} in both directions on both hosts", ports)};
  if (probe.silent == 0)
    return {"peer", Grade::kNote,
            fmt::format("peer {} answers, but no component runs there in domain {}", peer, domain),
            "start an island there, or look at its tuples.domain and tuples.interfaces"};
  return {"peer", Grade::kGood, fmt::format("peer {} answers, and something listens there in domain {}", peer, domain)};
}

Findings check_versions(const std::vector<client::ComponentStart>& seen, unsigned ours) {
  Findings all;
  for (const auto& one : seen) {
    if (!one.present || one.version == ours) continue;
    all.push_back({kVersion, Grade::kProblem,
                   fmt::format("component {} on {} uses protocol version {}, this program version {}: they "
                               "cannot communicate",
                               number(one.id), who(one), one.version, ours),
                   one.version > ours ? "install the same version of Rubicon here" : "install this version there"});
  }
  if (all.empty()) all.push_back({kVersion, Grade::kGood, fmt::format("all components use protocol version {}", ours)});
  return all;
}

Finding check_complaint(const std::string& text) {
  if (text.find("before the clock of its host was set") != text.npos ||
      text.find("the clock of this host says") != text.npos)
    return {
        "clock", Grade::kProblem, text,
        "on that host: `timedatectl` says whether its clock is set; its islands take part within seconds of that. A "
        "unit waits for it with `systemctl enable systemd-time-wait-sync`"};
  return {"complaint", Grade::kNote, text, "reported during the check; " + page("errors.md")};
}

Findings check_silent_participants(std::size_t silent, unsigned domain) {
  if (silent == 0) return {};
  return {{"silent", Grade::kNote,
           fmt::format("{} of domain {} {} no component: no program of Rubicon, or of a release that had certificates "
                       "for DDS",
                       counted(silent, "participant"), domain, silent == 1 ? "shows" : "show"),
           "islands of one network need the same release; " + page("trust.md")}};
}

Findings check_twins(const std::vector<client::ComponentStart>& seen) {
  std::map<OwnerId, std::vector<const client::ComponentStart*>> starts;
  for (const auto& one : seen) starts[one.id].push_back(&one);
  Findings all;
  for (const auto& entry : starts) {
    const auto& twins = entry.second;
    if (twins.size() < 2) continue;
    const auto there = std::count_if(twins.begin(), twins.end(), [](const auto* one) { return one->present; });
    std::string places;
    for (const auto* one : twins) places += (places.empty() ? "" : " and ") + who(*one);
    const auto id = number(entry.first);
    all.push_back({kTwins, Grade::kProblem,
                   there > 1 ? fmt::format("id {} is used by {} programs: {}", id, there, places)
                             : fmt::format("id {} started {} times during the check: {}", id, twins.size(), places),
                   fmt::format("give one of them another island.id; the one that started later exits by itself. Right "
                               "after a kill or a restart of {}, run doctor again in some seconds",
                               id)});
  }
  if (all.empty()) all.push_back({kTwins, Grade::kGood, "no duplicate ids"});
  return all;
}

}  // namespace rubicon::cli
