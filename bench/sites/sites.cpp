#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>

#include "components/rounds.h"
#include "frame/daemon.h"
#include "sites/broker.h"
#include "sites/measurements.h"
#include "sites/site.h"

namespace rubicon::bench::sites {

namespace {

constexpr std::uint32_t kFirstSite = 1001, kFirstDaemon = 9001;
constexpr int kSitesInProcess = 250, kDaemons = 20;
constexpr int kPatience = 60;  // seconds, of who lists

struct {
  std::vector<int> sites;
  int daemons = -1;  ///< by the number of sites
} asked;

int daemons_among(const Plan& plan, int sites) {
  if (!std::filesystem::exists(RUBICON_BINARY_DIR "/bin/rubicon-proxy")) return 0;
  if (asked.daemons >= 0) return std::min(asked.daemons, sites);
  return plan.is_quick ? 1 : std::min(kDaemons, sites / 5);
}

/// An island of the dummy network with as many thermometers and lamps as a Site.
std::string daemon_yaml(const Meeting& meeting, int number, int devices) {
  const auto thermometers = Site::thermometers(devices);
  return fmt::format(
      "island: {{id: {}, name: daemon-{}}}\nnetworks:\n  dummy-rooms:\n    type: dummy\n    simulate:\n"
      "      \"room-{{1..{}}}\": {{sensors: {{temperature-1: {{wave: sine, low: 18, high: 21, period: 120s}}}}}}\n"
      "      \"lamp-{{1..{}}}\": {{actuators: {{lamp-1: {{behaviour: obey}}}}}}\n"
      "tuples: {{mqtt: {{broker: \"127.0.0.1:{}\", space: {}, trust_broker: yes}}}}\n",
      kFirstDaemon + static_cast<std::uint32_t>(number), number, thermometers, devices - thermometers, port_of(meeting),
      meeting.tag);
}

/// All the sites, until it ends.
class Sites {
 public:
  Sites(const Meeting& meeting, int count, int daemons, int devices) {
    for (int i = 0; i < daemons; ++i) daemons_.push_back(std::make_unique<Daemon>(daemon_yaml(meeting, i, devices)));
    const int linked = count - daemons;
    for (int first = 0; first < linked; first += kSitesInProcess)
      processes_.push_back(start_role("many-sites", meeting,
                                      {{"first", kFirstSite + static_cast<std::uint32_t>(first)},
                                       {"count", std::min(kSitesInProcess, linked - first)},
                                       {"devices", devices}}));
  }

 private:
  std::vector<std::unique_ptr<Daemon>> daemons_;
  std::vector<Child> processes_;
};

/// Processor time of the broker a second, once it has nothing to do but to keep connections.
double quiet_share(const Plan& plan, const Broker& broker) {
  double share = 1;
  const int most = plan.is_quick ? 5 : 120;
  for (int i = 0; i < most && share > 0.05; ++i) {
    const auto before = broker.processor();
    std::this_thread::sleep_for(std::chrono::seconds(1));
    share = broker.processor() - before;
  }
  return share;
}

Json list_once(const Meeting& meeting, int expected, int patience) {
  auto listing = start_role("lister", meeting, {{"expected", expected}, {"patience_s", patience}});
  return result_of(listing);
}

/// Medians of the rounds; null: the list was not complete.
Json list_figures(const std::vector<Json>& rounds, int expected) {
  const bool complete =
      std::all_of(rounds.begin(), rounds.end(), [&](const Json& one) { return one.at("found") == expected; });
  return {{"list_s", complete ? Json(rounded(median_of(rounds, "seconds"), 2)) : Json(nullptr)},
          {"list_mb", rounded(median_of(rounds, "bytes") / 1e6, 2)},
          {"list_found", rounds.back().at("found")}};
}

Json measure_number(const Plan& plan, Report& report, int count) {
  const Broker broker(plan, report, "sites");
  if (!broker) return nullptr;
  const int devices = plan.is_quick ? 10 : 100, daemons = daemons_among(plan, count);
  const int expected = count * Site::thermometers(devices), rounds = plan.is_quick ? 1 : 3;
  const auto meeting = broker.new_meeting(plan);
  const Sites sites(meeting, count, daemons, devices);
  const auto first = list_once(meeting, expected, 3 * kPatience);
  if (plan.is_quick && first.at("found") != expected) give_up("a few sites are not listed");
  Json figures{{"daemons", daemons}, {"all_up_s", first.at("found") == expected ? first.at("seconds") : Json(nullptr)}};
  figures["broker_quiet_percent"] = rounded(quiet_share(plan, broker) * 100, 2);
  std::vector<Json> lists, switches;
  for (int round = 0; round < rounds; ++round) {
    lists.push_back(list_once(meeting, expected, kPatience));
    auto switching =
        start_role("switcher", meeting, {{"island", kFirstSite + static_cast<std::uint32_t>(round % count)}});
    switches.push_back(result_of(switching));
  }
  figures.update(list_figures(lists, expected));
  figures["lamp_s"] = rounded(median_of(switches, "seconds"), 3);
  figures["lamp_kb"] = rounded(median_of(switches, "bytes") / 1e3, 1);
  auto idle = start_role("idle-island", meeting,
                         {{"id", kFirstSite - 1},
                          {"devices", devices},
                          {"settle_s", plan.is_quick ? 1 : 10},
                          {"seconds", plan.is_quick ? 1 : 20}});
  figures["idle"] = result_of(idle);
  figures["broker_mb"] = broker.resident_mb();
  figures["rounds"] = {{"lists", lists}, {"lamps", switches}};
  return figures;
}

void tell_targets(Report& report, int count, const Json& figures) {
  const auto sites = fmt::format(" with {} sites", count);
  const auto within = [&](const char* name, double most) {
    const auto value = figures.at(name);
    report.target(name + sites, fmt::format("at most {}", most), value.is_number() && value.get<double>() <= most);
  };
  within("list_s", 10);
  within("list_mb", 40);
  within("lamp_s", 1);
  within("lamp_kb", 100);
  within("broker_mb", 300);
  const auto heard = figures.at("idle").at("heard_per_second").get<double>();
  report.target("idle_heard_bytes_per_second" + sites, "at most 200", heard <= 200);
}

}  // namespace

void add_options(CLI::App& app) {
  app.add_option("--sites", asked.sites, "measurement `sites`: so many (may be repeated; 10, 100 and 1000)")
      ->check(CLI::Range(1, 5000))
      ->allow_extra_args(false);
  app.add_option("--daemons", asked.daemons, "how many of them are rubicon-proxy; a fifth, at most 20")
      ->check(CLI::Range(0, 100));
}

void measure_sites(const Plan& plan, Report& report) {
  auto counts = asked.sites;
  if (counts.empty()) counts = plan.is_quick ? std::vector{3} : std::vector{10, 100, 1000};
  Json all, details;
  for (const auto count : counts) {
    auto figures = measure_number(plan, report, count);
    if (figures.is_null()) return;
    details[std::to_string(count)] = figures.at("rounds");
    figures.erase("rounds");
    tell_targets(report, count, figures);
    all[std::to_string(count)] = std::move(figures);
  }
  report.figure("sites", all);
  report.detail("sites",
                {{"method",
                  "sites with 100 devices each, 90 thermometers and 10 lamps, at one broker. list: from the start of a "
                  "newcomer that lists the devices with a temperature to its last one; lamp: from the start of a "
                  "newcomer to the reply of a site that it knows by its id; bytes of IP packets in both directions; "
                  "idle: of an island that nobody deals with"},
                 {"rounds", details}});
}

}  // namespace rubicon::bench::sites
