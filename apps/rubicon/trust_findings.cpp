#include "apps/rubicon/trust_findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "apps/rubicon/table.h"
#include "base/text.h"

namespace rubicon::cli {

namespace {

using Grade = Finding::Grade;

constexpr const char* kTrustCheck = "trust";
constexpr const char* kTrustDaysLeft = "trust-days-left";
constexpr const char* kRightsRefused = "rights-refused";
constexpr const char* kRefusedPeers = "dds-refused-peers";
constexpr std::string_view kPeersSubject = "dds", kWasRefused = "was refused";  // of lines about peers
/// Soon enough to renew in peace.
constexpr int kRenewDays = 30;

/// A part of the reasons that src/trust gives (a test compares them), and what to do. The first that fits counts.
struct Advice {
  std::string_view part, fix;
};
constexpr std::array kAdvice{
    Advice{
        "no group rubicon",
        "sudo addgroup --system rubicon, sudo rubicon trust dds init, sudo adduser USER rubicon, then log in again; or "
        "join with a certificate of your own: rubicon trust dds join FILE"},
    Advice{
        "gives it to the group rubicon",
        "sudo rubicon trust dds init, sudo adduser USER rubicon, then log in again; or join with a certificate of your "
        "own: rubicon trust dds join FILE"},
    Advice{"handed over no key", "journalctl -u 'rubicon-trust@*' says why the unit has no key"},
    Advice{"takes a member of your own", "join with a certificate of your own: rubicon trust dds join FILE"},
    Advice{"adduser",
           "sudo adduser USER rubicon, then log in again; or join with a certificate of your own: rubicon "
           "trust dds join FILE"},
    Advice{"may use this key",
           "this key may have been copied: revoke its member and add another name, or, if you "
           "know who could, chmod 600"},
    Advice{"a group may read this key",
           "this key may have been copied: revoke its member and add another name, or, if you "
           "know who could, chmod 600"},
    Advice{"others may change",
           "sudo chmod 644 as its owner; if you do not know who did this, make the folder again: "
           "rubicon trust dds join"},
    Advice{"set the clock of this host", "set the clock of this host (timedatectl)"},
    Advice{"the clock of this host says", "set the clock of this host (timedatectl)"},
    Advice{"is not valid before", "set the clock of this host (timedatectl)"},
    Advice{"ended on",
           "sudo rubicon trust dds renew on the host with the authority; elsewhere join with the file that it "
           "writes; then reload the islands"},
    Advice{"ended at",
           "sudo rubicon trust dds renew on the host with the authority; elsewhere join with the file that it "
           "writes; then reload the islands"},
    Advice{"revoked",
           "this member was shut out for good: `rubicon trust dds add` another name on the host with the "
           "authority"},
    Advice{"another version of Rubicon", "sudo apt install rubicon librubicon1: packages of the same version"},
    Advice{"islands of this host started with",
           "put the folder back from your copy, or join that realm again; a new realm shuts out all members of it"},
    Advice{"has no realm",
           "sudo rubicon trust dds init on the host with the islands, rubicon trust dds join on another one; "
           "or take part without: --trust no"},
    Advice{"realm",
           "this host joined another realm: compare the fingerprints of `rubicon trust dds show` on both hosts, "
           "then join with a file of the right one"},
    Advice{"guard", "install the package rubicon again: the library that checks who others are is missing or damaged"},
    Advice{"symbolic link", "the folder holds files, not links: join again into a new folder"},
    Advice{"may not", "`rubicon trust may NAME RIGHT KEY` names the rule of the island that decides"},
};

std::optional<std::int64_t> number_of(const IslandSeen& seen, const char* name) {
  const auto found = seen.properties.find(name);
  return found == seen.properties.end() ? std::nullopt : base::parse_number<std::int64_t>(found->second);
}

Finding end_of(const std::string& whose, std::int64_t days, const std::string& name) {
  const auto fix = fmt::format("sudo rubicon trust dds renew {}on the host with the authority; {}",
                               name.empty() ? "" : name + " ", page("trust.md#time"));
  if (days < 0) return {kTrustCheck, Grade::kProblem, fmt::format("the certificate of {} has ended", whose), fix};
  if (days < kRenewDays)
    return {kTrustCheck, Grade::kNote,
            fmt::format("the certificate of {} ends in {}", whose, counted(static_cast<std::size_t>(days), "day")),
            fix};
  return {kTrustCheck, Grade::kGood,
          fmt::format("the certificate of {} has {} left", whose, counted(static_cast<std::size_t>(days), "day"))};
}

/// The reason is in its log only.
Finding refused_peers(const IslandSeen& seen) {
  const auto count = static_cast<std::size_t>(seen.numbers.at(kRefusedPeers));
  auto what = fmt::format("island {} refused {} since its start", name_of(seen.island), counted(count, "peer"));
  if (!seen.refusal)
    return {kTrustCheck, Grade::kNote, what, "its log says which, and why: " + page("trust.md#what-to-do-when")};
  what += fmt::format("; at {}: {}", time_text(seen.refusal->time), seen.refusal->text);
  return {kTrustCheck, Grade::kNote, what,
          fmt::format("{}; `rubicon log --island {} --level warning` shows earlier ones",
                      page("trust.md#what-to-do-when"), number(seen.island.id))};
}

}  // namespace

std::string_view trust_remedy(std::string_view reason) {
  const auto found = std::find_if(kAdvice.begin(), kAdvice.end(),
                                  [&](const Advice& one) { return reason.find(one.part) != reason.npos; });
  return found == kAdvice.end() ? std::string_view() : found->fix;
}

std::vector<std::string_view> trust_reasons() {
  std::vector<std::string_view> all;
  for (const auto& one : kAdvice) all.push_back(one.part);
  return all;
}

Findings check_own_trust(const Result<std::shared_ptr<rubicon::trust::Trust>>& own) {
  if (!own) {
    const auto fix = trust_remedy(own.error().text);
    return {{kTrustCheck, Grade::kProblem, own.error().text,
             fix.empty() ? page("trust.md#what-to-do-when") : std::string(fix)}};
  }
  if (!*own) return {};
  const auto& name = (*own)->own().name;
  return {end_of(fmt::format("this program, {},", name), (*own)->days_left(), name)};
}

Findings check_other_side(const std::vector<client::Component>& islands, bool with_trust) {
  Findings all;
  for (const auto& island : islands) {
    if (with_trust) {
      all.push_back(
          {kTrustCheck, Grade::kProblem,
           fmt::format("island {} takes part without trust, this program with: they do not see each other",
                       name_of(island)),
           "give it trust: `tuples.trust: yes`, rubicon trust dds init, restart it; until then: rubicon --trust no"});
    } else {
      all.push_back({kTrustCheck, Grade::kProblem,
                     fmt::format("island {} has trust, this program takes part without: they do not see each other",
                                 name_of(island)),
                     "leave out `--trust no` and RUBICON_TRUST=no"});
    }
  }
  return all;
}

Findings check_silent_participants(std::size_t silent, unsigned domain, bool with_trust) {
  if (silent == 0) return {};
  const auto who = fmt::format("{} of domain {} {} no component to this program", counted(silent, "participant"),
                               domain, silent == 1 ? "shows" : "show");
  if (with_trust)
    return {{kTrustCheck, Grade::kNote,
             who + ": without trust, of another realm or refused, or no component of Rubicon",
             "the logs of the islands name whom they refused; `rubicon doctor --trust no` shows those without trust; " +
                 page("trust.md#what-to-do-when")}};
  return {
      {kTrustCheck, Grade::kNote, who + ": with trust, or no component of Rubicon",
       "take part with a certificate: --trust FOLDER, or rubicon trust dds join; " + page("trust.md#what-to-do-when")}};
}

bool has_refused_peers(const IslandSeen& seen) {
  const auto peers = seen.numbers.find(kRefusedPeers);
  return peers != seen.numbers.end() && peers->second > 0;
}

std::optional<LogLine> last_refusal(const std::vector<LogLine>& lines) {
  const auto is_one = [](const LogLine& line) {
    return line.subject == kPeersSubject && line.text.find(kWasRefused) != line.text.npos;
  };
  const auto found = std::find_if(lines.rbegin(), lines.rend(), is_one);
  return found == lines.rend() ? std::nullopt : std::optional(*found);
}

Findings check_island_trust(const IslandSeen& seen) {
  Findings all;
  if (const auto days = number_of(seen, kTrustDaysLeft))
    all.push_back(end_of("island " + name_of(seen.island), *days, ""));
  if (has_refused_peers(seen)) all.push_back(refused_peers(seen));
  const auto refused = seen.numbers.find(kRightsRefused);
  if (refused != seen.numbers.end() && refused->second > 0)
    all.push_back(
        {"rights", Grade::kNote,
         fmt::format("island {} refused {} by its rights since its start", name_of(seen.island),
                     counted(refused->second, "request")),
         fmt::format("on its host: `rubicon trust audit` lists them, `rubicon trust may NAME RIGHT KEY` names the "
                     "rule; {}",
                     page("rights.md"))});
  return all;
}

Finding check_access_with_trust(const IslandSeen& seen, bool on_peis) {
  const auto id = number(seen.island.id);
  if (on_peis)
    return {"access", Grade::kNote,
            fmt::format("on DDS island {} takes members only, as its rights say; on PEIS no peer proves who it is: "
                        "its peers may do what rules for `peis` allow",
                        id),
            page("rights.md")};
  return {"access", Grade::kNote, fmt::format("island {} takes members only, as its rights say", id),
          page("rights.md")};
}

}  // namespace rubicon::cli
