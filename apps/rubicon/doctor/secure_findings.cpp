#include "apps/rubicon/doctor/secure_findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

namespace rubicon::cli {

namespace {

using Grade = Finding::Grade;

/// A counter of dropped frames, why, and what to do.
struct Drop {
  std::string_view counter, meaning, fix;
};
constexpr std::array kDrops{
    Drop{"data-secure-refused", "commands and reads of secured groups that could not be sent",
         "the log and the answer to the command have the reason: no link in ETS between the group and the address of "
         "the island, no key, or no state file"},
    Drop{"data-secure-plain-dropped", "plain telegrams to secured groups",
         "the log names the sender: it was not downloaded since the group was secured, or the telegrams are forged"},
    Drop{"data-secure-no-key", "secured telegrams of groups without a key",
         "the keyring is older than the project: export it again and reload"},
    Drop{"data-secure-unknown-sender", "secured telegrams of devices that may not send to these groups",
         "the log names the device: if it was linked lately, export the keyring again and reload"},
    Drop{"data-secure-wrong-mac", "secured telegrams that were changed, or have another key",
         "download the sender that the log names, export the keyring again and reload"},
    Drop{"data-secure-old", "secured telegrams with an old sequence number",
         "few are repetitions on the bus, or replays; if a device that the log names is never heard again, it lost its "
         "number: download it in ETS"},
    Drop{"data-secure-other", "secured telegrams that cannot be read", "the log has the reasons"},
    Drop{"secure-plain-frames", "plain frames on a secured line",
         "the log names the sender: a plain router in the same multicast group, or forged frames"},
    Drop{"secure-early-frames", "frames before the authentication of the session",
         "the interface does not keep the rules: is there a newer firmware?"},
    Drop{"secure-wrong-mac", "frames that were changed, or have another key",
         "routing: download the routers in ETS, export the keyring again; tunnel: something changes frames on the way"},
    Drop{"secure-replays", "frames that arrived a second time",
         "something on the network repeats frames, or records "
         "and replays them"},
    Drop{"secure-other-sessions", "frames of another session", "a restart of the interface explains few of them"},
    Drop{"secure-forbidden-frames", "frames with content that is not permitted", "the log has the reasons"},
    Drop{"secure-forbidden", "frames with content that is not permitted", "the log has the reasons"},
    Drop{"secure-old", "frames beyond the latency tolerance of secure routing",
         "the network is slow, or they are replays; ETS sets the tolerance (Latency) of the backbone"},
    Drop{"secure-bad-frames", "frames that cannot be read", "the log has the reasons"},
};
constexpr std::string_view kUnverified = "secure-unverified";

std::uint64_t count_of(const Counters& counters, std::string_view name) {
  const auto found = counters.find(std::string(name));
  return found == counters.end() ? 0 : found->second;
}

/// `growth`: nullopt = not known.
Finding dropped(const std::string& who, const Drop& drop, std::uint64_t count, std::optional<std::uint64_t> growth) {
  const bool grows = growth.value_or(0) > 0;
  const auto change = grows ? fmt::format(", {} of them during the check", *growth)
                            : std::string(growth ? ", none during the check" : "");
  return {"secure", grows ? Grade::kProblem : Grade::kNote,
          fmt::format("{}: dropped {} ({}) since its start{}: {}", who, count, drop.counter, change, drop.meaning),
          fmt::format("{}; {}", drop.fix, page("knx-secure.md#counters"))};
}

Findings check_network(const std::string& who, const Counters* before, const Counters& now) {
  Findings all;
  const auto growth = before ? growth_of(*before, now) : Counters();
  for (const auto& drop : kDrops) {
    const auto count = count_of(now, drop.counter);
    if (count == 0) continue;
    all.push_back(dropped(who, drop, count, before ? std::optional(count_of(growth, drop.counter)) : std::nullopt));
  }
  if (count_of(now, kUnverified) > 0)
    all.push_back(
        {"secure", Grade::kNote,
         who + ": the interface is not verified: another device in its place would not be noticed",
         "name a file with its authentication code: `device-password-file`, or export the keyring of the whole "
         "project; " +
             page("knx-secure.md#counters")});
  return all;
}

}  // namespace

bool is_secure_counter(std::string_view name) {
  return std::any_of(kDrops.begin(), kDrops.end(), [&](const Drop& one) { return one.counter == name; });
}

Findings check_secure(const IslandSeen& seen) {
  Findings all;
  for (const auto& network : seen.now) {
    const auto known =
        std::find_if(seen.before.begin(), seen.before.end(), [&](const auto& one) { return one.id == network.id; });
    const bool compares = seen.known_before && known != seen.before.end();
    const auto before = compares ? counters_of(known->properties) : Counters();
    for (auto& one : check_network(fmt::format("network {} of island {}", network.id, name_of(seen.island)),
                                   compares ? &before : nullptr, counters_of(network.properties)))
      all.push_back(std::move(one));
  }
  return all;
}

}  // namespace rubicon::cli
