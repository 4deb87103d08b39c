#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/doctor/broker_findings.h"
#include "apps/rubicon/doctor/island_look.h"
#include "apps/rubicon/doctor/peis_findings.h"
#include "apps/rubicon/doctor/secure_findings.h"
#include "apps/rubicon/output/tuple_text.h"
#include "model/json_members.h"

namespace rubicon::cli {

namespace {

using Grade = Finding::Grade;

/// Other domains that are examined; each costs some threads for a moment.
constexpr std::size_t kMaxDomains = 8;
/// Announcements come at least this often.
constexpr std::chrono::milliseconds kListening{2500};
/// How often participants without components are counted again, and the time in between.
constexpr int kMaxLooks = 4;
constexpr std::chrono::milliseconds kLookPause{500};

/// Runs the checks one after the other and collects their findings.
class Doctor {
 public:
  Doctor(const Settings& settings, Duration length) : settings_(settings), options_(settings.options), length_(length) {
    options_.name = "rubicon doctor";
    if (options_.interfaces.empty() && is_distant()) options_.interfaces = {"lo"};
    options_.warn = [this](std::string_view text) { complaints_.emplace_back(text); };
  }

  const Findings& examine() {
    interfaces_ = transport::interfaces();
    add(check_interfaces(options_, interfaces_));
    look_at_udp();
    if (uses(options_, client::Engine::kMqtt)) look_at_sites();
    if (is_over_) return findings_;
    if (!is_distant()) return examine_host();
    return uses(options_, client::Engine::kDds) ? examine_dds() : examine_peis();
  }

 private:
  bool is_distant() const { return uses(options_, client::Engine::kDds) || uses(options_, client::Engine::kPeis); }

  const Findings& examine_host() {
    look_inside(0);
    if (islands_ > 0 || has_problem()) return findings_;
    add({{"islands", Grade::kProblem, fmt::format("no island in {}", place_text(options_)),
          "start one: rubicon-proxy run FILE" + elsewhere_text(options_)}});
    for (const auto& [domain, processes] : processes_by_domain(bound_ports()))
      add({{"other-domain", Grade::kNote,
            fmt::format("{} of this host use DDS in domain {}: they are of an earlier release, or serve a LAN",
                        counted(processes, "program"), domain),
            fmt::format("rubicon doctor --engine dds --domain {}", domain)}});
    return findings_;
  }

  const Findings& examine_dds() {
    const auto here = processes_by_domain(bound_ports());
    const auto ours = here.find(options_.domain);
    const auto processes = ours == here.end() ? 0 : ours->second;
    add({check_places(options_.domain, processes)});
    // DDS does not shut down where no datagram reaches it, so a client is opened only where UDP passes.
    const bool passes = !has_problem("firewall");
    if (passes && !has_problem("participant-index") && !has_problem("interface")) look_inside(processes);
    for (const auto& peer : options_.peers) {
      if (!options_.tcp) add({check_peer(peer, options_.domain, probe_peer(peer, options_.domain))});
    }
    add(check_silent_participants(silent_, options_.domain));
    if (passes) look_elsewhere(here);
    if (islands_ == 0 && !has_problem()) {
      add({{"islands", Grade::kProblem, fmt::format("no island in {}", place_text(options_)),
            "start one: rubicon-proxy run FILE (its tuples.engine must be dds, domain, tag and interfaces as here)"}});
    }
    return findings_;
  }

  /// An ecology without an island is nothing wrong there.
  const Findings& examine_peis() {
    if (!has_problem("interface")) look_inside(0);
    return findings_;
  }

  void add(Findings more) {
    for (auto& one : more) findings_.push_back(std::move(one));
  }
  bool has_problem(std::string_view check = {}) const {
    return std::any_of(findings_.begin(), findings_.end(), [&](const Finding& one) {
      return one.grade == Grade::kProblem && (check.empty() || one.check == check);
    });
  }

  /// A rule that drops UDP also drops it between this host's own addresses.
  void look_at_udp() {
    for (const auto& name : options_.interfaces) {
      const auto found =
          std::find_if(interfaces_.begin(), interfaces_.end(), [&](const auto& one) { return one.name == name; });
      if (found == interfaces_.end() || !found->is_up || found->address.empty()) continue;
      if (passes_udp(found->address)) {
        add({{"firewall", Grade::kGood, fmt::format("UDP passes at {} ({})", name, found->address)}});
      } else {
        add({{"firewall", Grade::kProblem,
              fmt::format("UDP from {} to itself ({}) does not arrive: something on this host drops it", name,
                          found->address),
              "allow UDP there: look at `nft list ruleset`, `iptables -S` and `tc qdisc`"}});
      }
    }
  }

  void look_at_sites() {
    const auto broker = look_at_broker(options_, settings_.patience);
    const auto realm = look_at_realm(options_, broker);
    if (!realm) add({{"sites", Grade::kProblem, realm.error().text, page("sites.md#realm-and-members")}});
    add(check_broker(broker, realm && *realm ? &**realm : nullptr,
                     std::chrono::floor<std::chrono::microseconds>(std::chrono::system_clock::now())));
    if (broker.failure) leave_out_broker();
  }

  /// Other components are seen without waiting for them.
  void leave_out_broker() {
    auto& engines = options_.engines;
    const bool named = !engines.empty();
    std::erase(engines, client::Engine::kMqtt);
    options_.broker = {};
    is_over_ = named && engines.empty();
  }

  void look_inside(unsigned processes) {
    auto opened = Client::open(options_);
    if (!opened) return tell_of_engine(opened.error().text);
    auto& client = **opened;
    const auto islands = cli::look_at_islands(client, length_, settings_.patience);
    islands_ = islands.size();
    if (const auto view = client.host_view()) {
      folder_ = view->folder;
      add(check_folder(*view));
    }
    const auto seen = client.component_starts();
    if (uses(options_, client::Engine::kDds)) {
      add(check_clocks(seen, std::chrono::floor<std::chrono::microseconds>(std::chrono::system_clock::now())));
      add(check_versions(seen, Client::protocol_version()));
      add(check_twins(seen));
    }
    if (const auto view = client.peis_view()) look_at_peis(client, *view);
    for (const auto& island : islands) examine(island);
    const auto present =
        static_cast<unsigned>(std::count_if(seen.begin(), seen.end(), [](const auto& one) { return one.present; }));
    count_silent(client);
    if (processes > 0 && present == 0 && silent_ == 0 && !has_problem("firewall")) {
      add({{"tag", Grade::kNote,
            fmt::format("{} of this host use domain {}, but were not discovered", counted(processes, "program"),
                        options_.domain),
            "they use another tuples.tag or other interfaces, or are not Rubicon components"}});
    }
    for (const auto& text : complaints_) {
      if (!is_told(text)) add({check_complaint(text)});
    }
  }

  /// A text that another check printed is not printed twice.
  bool is_told(const std::string& text) const {
    return std::any_of(findings_.begin(), findings_.end(), [&](const Finding& one) { return one.what == text; });
  }

  void tell_of_engine(const std::string& why) {
    if (!is_told(why)) add({{"engine", Grade::kProblem, why, "the text is that of the system or of the engine"}});
  }

  /// A presence may be under way.
  void count_silent(Client& client) {
    silent_ = client.silent_participants();
    for (int i = 0; i < kMaxLooks && silent_ > 0; ++i) {
      client.run_until([] { return false; }, kLookPause);
      silent_ = client.silent_participants();
    }
  }

  void look_at_peis(Client& client, const client::PeisView& view) {
    const auto components = client.components();
    add({check_peis_port(view, options_)});
    // Components on DDS say nothing about PEIS.
    if (!uses(options_, client::Engine::kDds)) add({check_peis_components(components, options_)});
    add(check_peis_troubles(view, options_, components));
    std::set<OwnerId> present{client.id()};
    std::vector<client::Tuple> of_kernels;
    for (const auto& one : components) {
      present.insert(one.id);
      if (!is_kernel(one)) continue;
      auto some = client.read({one.id, "**"}, settings_.patience);
      std::move(some.begin(), some.end(), std::back_inserter(of_kernels));
    }
    add(check_peis_ids(of_kernels, present));
  }

  void examine(const IslandSeen& seen) {
    const auto name = name_of(seen.island);
    if (!seen.answers)
      return add({{"islands", Grade::kProblem, fmt::format("island {} is present, but does not answer", name),
                   "its program hangs, or UDP to this host is blocked: allow it in both directions; or its rights do "
                   "not let this program read anything"}});
    add({{"islands", Grade::kGood, fmt::format("island {} answers", name)}});
    const auto now = std::chrono::floor<std::chrono::microseconds>(std::chrono::system_clock::now());
    add(check_lines(seen, now));
    add(check_devices(seen));
    add(check_losses(seen));
    add(check_broker_losses(seen));
    add(check_problems(seen, now));
    add(check_peis_counters(seen));
    add(check_secure(seen));
    add(check_disks(seen));
    add(check_history(seen));
    add(check_bridges(seen));
    add(check_clock(seen, now));
    add(check_alerts(seen));
    add(check_inbox(seen));
    add(check_unusable(seen));
    add(check_settings(seen));
    add(check_brokers(seen));
    add(check_interfaces_of(seen));
    add(check_held_back(seen));
    add(check_rights(seen));
    if (!is_distant()) return add({check_access_of_host(seen, folder_)});
    add({check_access(seen, options_)});
  }

  void look_elsewhere(const std::map<unsigned, unsigned>& here) {
    std::set<unsigned> domains;
    for (const auto& entry : here) domains.insert(entry.first);
    if (islands_ == 0) {
      for (const auto& one : interfaces_) {
        const bool asked = std::count(options_.interfaces.begin(), options_.interfaces.end(), one.name) > 0;
        if (asked && one.has_multicast && !one.address.empty())
          domains.merge(domains_heard(one.address, options_.domain, kListening));
      }
    }
    domains.erase(options_.domain);
    std::vector<std::pair<unsigned, std::unique_ptr<Client>>> clients;
    for (const auto domain : domains) {
      auto options = options_;
      options.domain = domain;
      options.engines = {client::Engine::kDds};
      options.warn = nullptr;
      if (clients.size() >= kMaxDomains) break;
      if (auto opened = Client::open(options)) clients.emplace_back(domain, std::move(*opened));
    }
    for (const auto& entry : clients) {
      auto& client = *entry.second;
      client.run_until([&] { return !client.tuples().peers().empty(); }, std::chrono::seconds(1));
      client.discover();
      for (const auto& island : client.islands()) {
        add({{"other-domain", islands_ == 0 ? Grade::kProblem : Grade::kNote,
              fmt::format("island {} {} is in domain {}, rubicon looks in domain {}", number(island.id),
                          island.summary.name, entry.first, options_.domain),
              fmt::format("--domain {} or RUBICON_DOMAIN={}; or tuples.domain: {} of the island", entry.first,
                          entry.first, options_.domain)}});
      }
    }
  }

  const Settings& settings_;
  client::Options options_;
  Duration length_;
  std::vector<transport::Interface> interfaces_;
  std::size_t islands_ = 0;
  std::string folder_;      ///< of this host
  std::size_t silent_ = 0;  ///< participants of the domain that show no component
  bool is_over_ = false;    ///< there is only a broker, which is not reached
  std::vector<std::string> complaints_;
  Findings findings_;
};

void show(Output& out, const Findings& findings) {
  const Look look{out.has_colour(), 0};
  for (const auto& one : findings) {
    const auto grade = std::string(to_string(one.grade));
    out.line(fmt::format("{}  {:<17}  {}", painted(grade, fmt::format("{:<7}", grade), look.colour), one.check,
                         printable(one.what)));
    if (!one.fix.empty()) out.line(fmt::format("{:<9}{:<19}{}", "", "fix:", printable(one.fix)));
  }
}

/// The note `access` is always there, and not counted.
std::string verdict(const Findings& findings) {
  std::size_t problems = 0, notes = 0;
  for (const auto& one : findings) {
    if (one.grade == Grade::kProblem) ++problems;
    if (one.grade == Grade::kNote && one.check != "access") ++notes;
  }
  if (problems > 0) return counted(problems, "problem");
  return notes == 0 ? "nothing is wrong" : fmt::format("no problem, {} to look at", counted(notes, "note"));
}

int doctor(const Settings& settings, Duration length) {
  Output out(1);
  Doctor one(settings, length);
  const auto& findings = one.examine();
  const auto problems = std::count_if(findings.begin(), findings.end(),
                                      [](const Finding& finding) { return finding.grade == Grade::kProblem; });
  if (settings.json) {
    for (const auto& finding : findings) {
      out.line(model::dump({{"check", finding.check},
                            {"grade", to_string(finding.grade)},
                            {"what", finding.what},
                            {"mend", finding.fix}}));
    }
  } else {
    show(out, findings);
    out.line(verdict(findings));
  }
  return ended(out, problems == 0 ? kGood : kFailed);
}

}  // namespace

void add_doctor(Cli& cli) {
  const auto length = std::make_shared<std::string>();
  auto* app = cli.command(
      {"doctor", "Diagnose the ecology as seen from this host, and name the fixes",
       "  rubicon doctor\n"
       "  rubicon doctor --interfaces eth0 --peers 10.0.0.2\n"
       "  rubicon doctor --json\n"
       "Exit code 1 if there is a problem. Checks interfaces, multicast, UDP, free participant indexes,\n"
       "other domains, duplicate ids and protocol versions; on PEIS ports, other networks, unreachable\n"
       "components, ids that two programs use or that no component has; of a broker its rights, users\n"
       "and realm; and of each island, twice, its lines, devices, losses, KNX Secure, disks, history, bridges,\n"
       "clock, alerts, inbox, names that cannot be used, and settings of servers behind networks.\n"},
      [length](const Settings& settings) {
        return doctor(settings, parse_duration_or(*length, std::chrono::milliseconds(2500)));
      });
  add_duration_option(app, "--for", *length, "time between the two checks of an island; default 2.5s");
}

}  // namespace rubicon::cli
