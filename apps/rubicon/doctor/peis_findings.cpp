#include "apps/rubicon/doctor/peis_findings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>

#include "apps/rubicon/doctor/signs.h"
#include "apps/rubicon/output/tuple_text.h"
#include "base/text.h"
#include "tuples/meta_tuple.h"

namespace rubicon::cli {

namespace {

using Grade = Finding::Grade;
using client::PeisTrouble;

constexpr std::string_view kPrefix = "peis-";

std::string page_of_peis() {
  return page("ecology.md#peis");
}

/// `component 42 (tupleview@desk!4711)`
std::string who(const PeisTrouble& one) {
  if (one.id == model::kNoOwner) return one.name.empty() ? "a program" : one.name;
  return fmt::format("component {}{}", number(one.id), one.name.empty() ? "" : " (" + one.name + ")");
}

Finding finding_of(const PeisTrouble& one, const client::Options& options, bool is_present) {
  switch (one.kind) {
    case PeisTrouble::Kind::kForeignNetwork:
      return {"peis-network", Grade::kNote,
              fmt::format("{} belongs to PEIS network {}, rubicon looks in network {}", who(one), one.detail,
                          options.peis.network),
              fmt::format("--peis-network {0} or RUBICON_PEIS_NETWORK={0} to see it; tuples.peis.network of an island",
                          one.detail)};
    case PeisTrouble::Kind::kForeignVersion:
      return {"version", Grade::kProblem, fmt::format("{} has another version of PEIS: {}", who(one), one.detail),
              "use kernels of protocol 500 (version 0.6 of G6)"};
    case PeisTrouble::Kind::kUnreachable:
      return {"unreachable", is_present ? Grade::kNote : Grade::kProblem,
              fmt::format("{} cannot be connected to{}: {}", who(one),
                          is_present ? ", others pass its messages on" : "", one.detail),
              "see whether it still runs, whether a firewall drops its TCP port, and whether it is in the same PEIS "
              "network: a kernel closes connections of others"};
    case PeisTrouble::Kind::kOwnId:
    case PeisTrouble::Kind::kSharedId:
      return {
          "id-twice", Grade::kProblem,
          one.kind == PeisTrouble::Kind::kOwnId
              ? fmt::format("{} has the id of this program", who(one))
              : fmt::format("id {} is used by two programs, {} is one of them", number(one.id), one.name),
          "give one of them another id: --peis-id of a kernel (it draws one from 0 to 9999), island.id of an island"};
  }
  return {};
}

/// The ids in a value of `kernel.subscribers`: `(\n  ( <subscriber> <owner>.<key> )\n)\n`. An owner of -1 is any.
std::set<OwnerId> ids_in_subscribers(std::string_view text) {
  std::set<OwnerId> ids;
  for (auto at = text.find("( "); at != text.npos; at = text.find("( ", at)) {
    text.remove_prefix(at + 2);
    const auto subscriber = base::parse_number<std::uint32_t>(text.substr(0, text.find(' ')));
    const auto blank = std::min(text.find(' '), text.size() - 1);
    const auto rest = text.substr(blank + 1);
    const auto owner = base::parse_number<std::uint32_t>(rest.substr(0, rest.find('.')));
    for (const auto& id : {subscriber, owner}) {
      if (id) ids.insert(OwnerId(*id));
    }
    at = 0;
  }
  return ids;
}

std::set<OwnerId> ids_in(const client::Tuple& tuple) {
  if (tuple.key == "kernel.subscribers") return ids_in_subscribers(tuple.value);
  const bool is_theirs = tuple.value.starts_with("(META ");
  if (!is_theirs && !tuples::is_reference(tuple.media_type)) return {};
  const auto media_type = is_theirs ? tuples::kPeisReferenceMediaType : std::string_view(tuple.media_type);
  const auto target = tuples::read_reference(media_type, tuple.value);
  return target ? std::set<OwnerId>{target->owner} : std::set<OwnerId>{};
}

/// What a counter says to people.
struct Meaning {
  std::string_view name, what, fix;
  Grade grows = Grade::kNote;  ///< while it grows
};

constexpr std::string_view kTheirs = "the island's log names them; find the program that sends it";

constexpr std::array kMeanings{
    Meaning{"refused-keys", "own tuples that kernels do not see",
            "give them keys of at most 7 parts and 127 characters that do not differ only in case; the island's log "
            "names them"},
    Meaning{"refused-sets", "remote sets of kernels were refused; PEIS does not tell the kernels",
            "the island's log has the reasons; a kernel on another host needs tuples.trust_lan: yes"},
    Meaning{"refused-patterns", "subscriptions of kernels that cannot be served",
            "a kernel may have 10,000 subscriptions with keys of at most 7 parts and data of at most 1 KiB"},
    Meaning{"ignored-quits", "a program asked the island to end by kernel.do-quit, which was ignored",
            "the island's log names the program; end an island by its service"},
    Meaning{"own-id-seen", "another program uses the id of the island", "give one of them another id", Grade::kProblem},
    Meaning{"given-up", "messages that were not acknowledged in 11.6 s",
            "the other program hangs, is overloaded, or a network between drops its packages"},
    Meaning{"foreign-networks", "programs of other PEIS networks tried to connect, or announce themselves",
            "tuples.peis.network must be the same for all that should see each other"},
    Meaning{"foreign-versions", "programs with another version of the protocol", "use kernels of protocol 500"},
    Meaning{"bad-streams", "connections that were closed for bytes that are not PEIS", kTheirs},
    Meaning{"bad-announcements", "announcements that are not PEIS", kTheirs},
    Meaning{"bad-bodies", "messages of the network level that cannot be decoded", kTheirs},
    Meaning{"bad-messages", "messages of tuples that cannot be decoded", kTheirs},
    Meaning{"bad-ids", "packages with an id that no component may have", kTheirs},
    Meaning{"high-ports", "packages with a port above 49, which end kernels; they were dropped", kTheirs},
    Meaning{"forged-deaths", "messages that declare another component dead; they were ignored", kTheirs},
    Meaning{"held-deaths", "a component asked for everything again and again; it gets it once in 10 s", kTheirs},
    Meaning{"forged-hellos", "a component spoke in the name of another one; this was ignored", kTheirs},
    Meaning{"other-starts",
            "a message says that a component that is up has started again; it counts only when that component connects",
            kTheirs},
    Meaning{"foreign-tuples", "tuples that a component sent for another owner; they were ignored", kTheirs},
    Meaning{"unknown-keys", "tuples of kernels whose keys cannot be keys here", kTheirs},
    Meaning{"copies-not-kept", "tuples of kernels beyond 200,000 or 128 MiB of one kernel",
            "subscribe to less of that kernel"},
    Meaning{"lost-pushes", "tuples that a kernel did not acknowledge in 11.6 s; they are sent again until it does",
            "the kernel hangs, is overloaded, or a network between drops its packages"},
    Meaning{"dropped-replies", "replies that their components did not read", "the component hangs or is overloaded"},
    Meaning{"queue-full", "packages of others that could not be passed on", "connect these components directly"},
    Meaning{"stuck-links", "connections that took no bytes for 2 s", "the other program hangs or is overloaded"},
    Meaning{"silent-links", "connections that were silent for too long", "the other program hangs, or a cable is out"},
    Meaning{"fragments-dropped", "parts of long messages that could not be put together", kTheirs},
    Meaning{"too-many-hosts", "hosts beyond 1,024", "split the network: tuples.peis.network"},
    Meaning{"too-many-routes", "routes beyond the bound", "split the network: tuples.peis.network"},
    Meaning{"too-many-links", "connections beyond 256", "split the network: tuples.peis.network"},
};

const Meaning* meaning_of(std::string_view name) {
  if (!name.starts_with(kPrefix)) return nullptr;
  name.remove_prefix(kPrefix.size());
  const auto found =
      std::find_if(kMeanings.begin(), kMeanings.end(), [&](const auto& one) { return one.name == name; });
  return found == kMeanings.end() ? nullptr : &*found;
}

}  // namespace

bool is_peis_counter(std::string_view name) {
  return name.starts_with(kPrefix);
}

bool is_kernel(const client::Component& component) {
  return component.summary.program.starts_with("peis-kernel");
}

Finding check_peis_port(const client::PeisView& view, const client::Options& options) {
  if (view.local.empty())
    return {"peis-port", Grade::kProblem,
            fmt::format("no TCP port from {} on is free for PEIS on this host", options.peis.listen),
            "end programs that are not needed (`ss -ltnp` lists them), or give another first port: --peis-listen, "
            "tuples.peis.listen"};
  return {"peis-port", Grade::kGood, fmt::format("this program listens at {} for PEIS components", view.local)};
}

Finding check_peis_components(const std::vector<client::Component>& components, const client::Options& options) {
  const auto kernels = static_cast<std::size_t>(std::count_if(components.begin(), components.end(), is_kernel));
  if (!components.empty())
    return {"peis-components", Grade::kGood,
            fmt::format("PEIS network {}: {}, {} of ours", options.peis.network, counted(kernels, "kernel"),
                        counted(components.size() - kernels, "component"))};
  return {
      "peis-components", Grade::kProblem,
      fmt::format("no component in PEIS network {} on {}", options.peis.network, fmt::join(options.interfaces, ", ")),
      fmt::format("start one with network {}; if multicast does not reach it: --peis-connect tcp://HOST:PORT",
                  options.peis.network)};
}

Findings check_peis_troubles(const client::PeisView& view, const client::Options& options,
                             const std::vector<client::Component>& components) {
  Findings all;
  for (const auto& one : view.troubles) {
    const bool is_present =
        std::any_of(components.begin(), components.end(), [&](const auto& other) { return other.id == one.id; });
    all.push_back(finding_of(one, options, is_present));
  }
  return all;
}

Findings check_peis_ids(const std::vector<client::Tuple>& of_kernels, const std::set<OwnerId>& present) {
  Findings all;
  for (const auto& tuple : of_kernels) {
    std::vector<std::uint32_t> unknown;
    for (const auto id : ids_in(tuple)) {
      if (id != model::kNoOwner && !present.contains(id)) unknown.push_back(number(id));
    }
    if (unknown.empty()) continue;
    all.push_back({"unknown-id", Grade::kNote,
                   fmt::format("{} names {} {}, which no component has", name_of(tuple.owner, tuple.key),
                               unknown.size() == 1 ? "id" : "ids", fmt::join(unknown, ", ")),
                   "start that component, or correct the id in the configuration of the program; a kernel lists "
                   "subscribers that are gone until it is restarted"});
  }
  if (all.empty()) all.push_back({"unknown-id", Grade::kGood, "all ids that kernels name are present"});
  return all;
}

Findings check_peis_counters(const IslandSeen& seen) {
  Findings all;
  const auto growth = seen.known_before ? growth_of(seen.numbers_before, seen.numbers) : Counters();
  for (const auto& [name, count] : seen.numbers) {
    const auto* meaning = meaning_of(name);
    if (!meaning || count == 0) continue;
    const auto grown = growth.find(name);
    const bool grows = grown != growth.end();
    all.push_back({"peis", grows ? meaning->grows : Grade::kNote,
                   fmt::format("island {}: {} = {}{}: {}", name_of(seen.island), name, count,
                               grows ? fmt::format(" (+{} during the check)", grown->second) : "", meaning->what),
                   fmt::format("{}; {}", meaning->fix, page_of_peis())});
  }
  return all;
}

}  // namespace rubicon::cli
