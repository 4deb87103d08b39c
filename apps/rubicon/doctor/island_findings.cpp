#include "apps/rubicon/doctor/island_findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "apps/rubicon/doctor/peis_findings.h"
#include "apps/rubicon/doctor/remedies.h"
#include "apps/rubicon/doctor/secure_findings.h"
#include "apps/rubicon/output/table.h"
#include "apps/rubicon/output/tuple_text.h"
#include "base/clocks.h"
#include "model/json_members.h"
#include "model/json_text.h"

namespace rubicon::cli {

namespace {

using client::Network;
using Grade = Finding::Grade;

constexpr const char* kRightsRefused = "rights-refused";
constexpr const char* kLine = "line";
constexpr const char* kLoss = "loss";
constexpr const char* kDisk = "disk";
/// A line that is connecting for longer is a problem.
constexpr std::chrono::seconds kOpening{10};
/// Larger differences between clocks are a problem.
constexpr std::chrono::seconds kClock{2};
/// Problems of a network that are listed one by one.
constexpr std::size_t kMaxProblemsShown = 10;
/// Less free space is a problem.
constexpr std::uint64_t kLittleRoom = 100'000'000;
/// A clock before 2020 was never set.
constexpr WallTime kEarliest{std::chrono::seconds(1'577'836'800)};

std::string megabytes(std::uint64_t bytes) {
  return fmt::format("{:.0f} MB", static_cast<double>(bytes) / 1e6);
}

Finding check_line(const IslandSeen& seen, const Network& network, WallTime when) {
  const auto& line = network.line;
  const auto what = fmt::format("network {} of island {}: ", network.id, name_of(seen.island));
  const auto since = age_text(line.since, when);
  const auto* remedy = remedy_of(line.finding);
  if (line.works()) {
    const auto state = fmt::format("{}{} for {}, {} of {} devices reachable", what, line.line, since, network.reachable,
                                   network.devices);
    if (line.reason.empty() || line.line == "ended") return {kLine, Grade::kGood, state};
    const auto text = fmt::format("{}; {}", state, line.reason);
    if (network.id.starts_with("zigbee"))
      return {kLine, Grade::kNote, text, "the text says what to do; " + page("zigbee.md#troubles")};
    if (!remedy) return {kLine, Grade::kNote, text, page("errors.md#lines-and-devices")};
    return {kLine, when - line.since < kOpening ? Grade::kNote : Grade::kProblem, text,
            fmt::format("{}; {}", remedy->fix, page(remedy->page))};
  }
  if (line.line == "connecting" && when - line.since < kOpening)
    return {kLine, Grade::kNote, what + "is being opened", "run doctor again in some seconds"};
  const auto next = next_attempt_text(line, when);
  const auto text =
      fmt::format("{}{} for {}: {}", what, line.line, since, line.reason.empty() ? "no reason reported" : line.reason);
  if (remedy)
    return {kLine, Grade::kProblem, text,
            fmt::format("{}{}{}; {}", remedy->fix, next.empty() ? "" : "; ", next, page(remedy->page))};
  return {
      kLine, Grade::kProblem, text,
      fmt::format("check cable, power and network of the device that `networks: {}:` names, and its address there; the "
                  "island keeps trying ({} attempts so far{}{}); {}",
                  network.id, line.attempts, next.empty() ? "" : ", ", next, page("errors.md#lines-and-devices"))};
}

/// `before`: nullptr = not known.
Findings check_counters(const std::string& who, const Counters* before, const Counters& now) {
  Findings all;
  const auto losses = losses_of(now);
  const auto growth = before ? growth_of(*before, losses) : Counters();
  const auto* still = before ? ", unchanged during the check" : "; first value unknown";
  for (const auto& [name, count] : losses) {
    if (is_secure_counter(name) || is_peis_counter(name)) continue;
    const auto grown = growth.find(name);
    const bool grows = grown != growth.end();
    all.push_back({kLoss, grows ? Grade::kProblem : Grade::kNote,
                   grows ? fmt::format("{}: {} grew by {} to {} during the check", who, name, grown->second, count)
                         : fmt::format("{}: {} = {} since its start{}", who, name, count, still),
                   fmt::format("the island's log has the reasons; {} explains the counter",
                               page("tuple-keys.md#devices-and-networks"))});
  }
  return all;
}

/// One entry of the property `problems` of a network.
Finding problem_of(const std::string& whose, const nlohmann::json& entry, WallTime when) {
  const auto problem = entry.is_object() ? entry : nlohmann::json::object();
  const auto count = model::count_of(problem, "count");
  const auto last = model::time_of(problem, "time");
  return {"problem", Grade::kNote,
          fmt::format("{}: {} ({}): {}", whose, model::text_of(problem, "address"), model::text_of(problem, "what"),
                      model::text_of(problem, "reason")),
          fmt::format("{}, last {} ago; {}", count == 1 ? "once" : fmt::format("{} times", count), age_text(last, when),
                      page("knx.md#what-cannot-be-used"))};
}

const Network* find(const std::vector<Network>& networks, const std::string& id) {
  const auto found = std::find_if(networks.begin(), networks.end(), [&](const auto& one) { return one.id == id; });
  return found == networks.end() ? nullptr : &*found;
}

Finding check_disk(const IslandSeen& seen, const std::string& of, std::uint64_t free) {
  const auto what = fmt::format("island {}: {} free for {}", name_of(seen.island), megabytes(free), of);
  if (free >= kLittleRoom) return {kDisk, Grade::kGood, what};
  return {kDisk, Grade::kProblem, what, "free space on that disk; what cannot be written is lost and counted"};
}

}  // namespace

std::string name_of(const client::Component& island) {
  const auto id = std::to_string(number(island.id));
  return island.summary.name.empty() ? id : id + " " + island.summary.name;
}

std::string page(std::string_view name) {
  namespace fs = std::filesystem;
  std::error_code error;
  const auto program = fs::read_symlink("/proc/self/exe", error);  // PREFIX/bin/rubicon
  const auto folder = program.parent_path().parent_path() / RUBICON_DOC_DIR / "docs";
  const bool installed = !error && fs::exists(folder / name.substr(0, name.find('#')), error);
  return fmt::format("{}/{}", installed ? folder.string() : "docs", name);
}

Findings check_lines(const IslandSeen& seen, WallTime when) {
  Findings all;
  for (const auto& network : seen.now) all.push_back(check_line(seen, network, when));
  return all;
}

Findings check_devices(const IslandSeen& seen) {
  Findings all;
  for (const auto& network : seen.now) {
    if (!network.line.works() || network.reachable >= network.devices) continue;
    all.push_back({"devices", Grade::kNote,
                   fmt::format("network {} of island {}: {} of {} devices {} not reachable", network.id,
                               name_of(seen.island), network.devices - network.reachable, network.devices,
                               network.devices - network.reachable == 1 ? "is" : "are"),
                   fmt::format("rubicon devices --island {} --network {}", number(seen.island.id), network.id)});
  }
  return all;
}

Findings check_losses(const IslandSeen& seen) {
  const auto* numbers = seen.known_before ? &seen.numbers_before : nullptr;
  auto all = check_counters("island " + name_of(seen.island), numbers, seen.numbers);
  for (const auto& network : seen.now) {
    const auto* before = seen.known_before ? find(seen.before, network.id) : nullptr;
    const auto counters = before ? counters_of(before->properties) : Counters();
    for (auto& one : check_counters(fmt::format("network {} of island {}", network.id, name_of(seen.island)),
                                    before ? &counters : nullptr, counters_of(network.properties)))
      all.push_back(std::move(one));
  }
  if (all.empty()) all.push_back({kLoss, Grade::kGood, fmt::format("island {} lost nothing", name_of(seen.island))});
  return all;
}

Findings check_problems(const IslandSeen& seen, WallTime when) {
  Findings all;
  for (const auto& network : seen.now) {
    const auto text = network.properties.find("problems");
    const auto list = text == network.properties.end() ? nlohmann::json() : model::parse_json(text->second);
    if (!list.is_array()) continue;
    const auto whose = fmt::format("network {} of island {}", network.id, name_of(seen.island));
    for (std::size_t i = 0; i < std::min(list.size(), kMaxProblemsShown); ++i)
      all.push_back(problem_of(whose, list[i], when));
    if (list.size() > kMaxProblemsShown)
      all.push_back({"problem", Grade::kNote,
                     fmt::format("{}: {} more problems", whose, list.size() - kMaxProblemsShown),
                     fmt::format("rubicon get '{}.property.problems.value'", network.id)});
  }
  return all;
}

Findings check_disks(const IslandSeen& seen) {
  constexpr std::string_view kFree = "-free-bytes";
  Findings all;
  for (const auto& [name, free] : seen.numbers) {
    if (!name.ends_with(kFree)) continue;
    const auto of = name.substr(0, name.size() - kFree.size());
    all.push_back(check_disk(seen, of == "state" ? "its state file" : of, free));
  }
  for (const auto& [name, state] : seen.properties) {
    if (!name.starts_with("recorder-") || !name.ends_with("-state") || state == "recording") continue;
    if (state == "stopped") {
      all.push_back({kDisk, Grade::kNote, fmt::format("island {}: {}: stopped by a user", name_of(seen.island), name),
                     "rubicon recorder NAME start"});
      continue;
    }
    all.push_back(
        {kDisk, Grade::kProblem, fmt::format("island {}: {}: {}", name_of(seen.island), name, state),
         fmt::format("free space on the disk, or correct `recorders:`; {}", page("errors.md#lines-and-devices"))});
  }
  return all;
}

Findings check_history(const IslandSeen& seen) {
  if (seen.history.empty()) return {};
  const auto status = model::object_of(seen.history);
  const auto state = model::text_of(status, "state"), file = model::text_of(status, "file");
  const auto whose = fmt::format("the history of island {} ({})", name_of(seen.island), file);
  if (state == "opening")
    return {{"history", Grade::kNote, whose + " is being checked and opened; it keeps nothing yet"}};
  if (state != "recording")
    return {{"history", Grade::kProblem, fmt::format("{} is not written: {}", whose, model::text_of(status, "reason")),
             fmt::format("free space on its disk, or correct `history:`; it tries again by itself; {}",
                         page("history.md#when-something-fails"))}};
  const auto dropped = model::count_of(status, "dropped");
  if (dropped > 0)
    return {{"history", Grade::kNote, fmt::format("{} is written, but dropped {} values before", whose, dropped),
             "the island's log has the reason"}};
  return {{"history", Grade::kGood, whose + " is written"}};
}

namespace {

/// One of the reasons of a bridge that is up.
Finding bridge_finding(const std::string& whose, const nlohmann::json& part, const std::string& usual_fix) {
  const auto said = part.is_object() ? part : nlohmann::json::object();
  const auto* remedy = remedy_of(model::text_of(said, "finding"));
  return {"bridges", Grade::kNote, fmt::format("{} is up; {}", whose, model::text_of(said, "text")),
          remedy ? fmt::format("{}; {}", remedy->fix, page(remedy->page)) : usual_fix};
}

}  // namespace

Findings check_bridges(const IslandSeen& seen) {
  Findings all;
  for (const auto& [name, text] : seen.bridges) {
    const auto status = model::object_of(text);
    const auto state = model::text_of(status, "state"), reason = model::text_of(status, "reason");
    const auto whose =
        fmt::format("bridge {} of island {} ({})", name, name_of(seen.island), model::text_of(status, "peer"));
    const bool is_ros = model::text_of(status, "peer").starts_with("ROS ");
    const auto fix = page(is_ros ? "ros2.md#troubles" : "mqtt.md#troubles");
    const auto parts = status.value("findings", nlohmann::json::array());
    if (state != "up")
      all.push_back({"bridges", Grade::kProblem, fmt::format("{} is not connected: {}", whose, reason), fix});
    else if (parts.is_array() && !parts.empty())
      for (const auto& part : parts) all.push_back(bridge_finding(whose, part, fix));
    else if (!reason.empty())
      all.push_back({"bridges", Grade::kNote, fmt::format("{} is up; {}", whose, reason), fix});
    else
      all.push_back({"bridges", Grade::kGood,
                     fmt::format("{} is up, with {} of {}", whose, counted(model::count_of(status, "points"), "point"),
                                 counted(model::count_of(status, "devices"), "device"))});
  }
  return all;
}

Findings check_clock(const IslandSeen& seen, WallTime when) {
  if (when < kEarliest)
    return {{"clock", Grade::kProblem, fmt::format("the clock of this host says {}", time_text(when)),
             "set it: timedatectl set-ntp true"}};
  if (!seen.clock_offset) return {};
  const auto offset = *seen.clock_offset;
  const auto seconds = std::abs(std::chrono::duration<double>(offset).count());
  const auto whose = fmt::format("the clock of island {} ({})", name_of(seen.island), seen.island.summary.host);
  if (when + std::chrono::duration_cast<std::chrono::microseconds>(offset) < kEarliest)
    return {{"clock", Grade::kProblem, fmt::format("{} was never set: it is {:.0f} s behind this one", whose, seconds),
             "set it: timedatectl set-ntp true there"}};
  if (std::chrono::abs(offset) > kClock)
    return {{"clock", Grade::kProblem,
             fmt::format("{} is {:.1f} s {} this one", whose, seconds, offset > Duration(0) ? "ahead of" : "behind"),
             "timedatectl timesync-status on both hosts; times in tuples are those of their islands"}};
  return {{"clock", Grade::kGood, fmt::format("{} agrees with this one", whose)}};
}

Findings check_alerts(const IslandSeen& seen) {
  Findings all;
  for (const auto& one : seen.alerts.all) {
    if (one.kind != "battery-low" && one.kind != "command-failed") continue;
    all.push_back({"alerts", Grade::kNote, fmt::format("island {}: {}", name_of(seen.island), one.what), one.fix});
  }
  return all;
}

Findings check_inbox(const IslandSeen& seen) {
  const auto waiting = seen.numbers.find("inbox-waiting");
  if (waiting == seen.numbers.end() || waiting->second == 0) return {};
  return {{"inbox", Grade::kNote,
           fmt::format("{} of island {} for a decision",
                       waiting->second == 1 ? "1 device waits" : fmt::format("{} devices wait", waiting->second),
                       name_of(seen.island)),
           fmt::format("rubicon inbox --island {}", number(seen.island.id))}};
}

Findings check_unusable(const IslandSeen& seen) {
  Findings all;
  for (const auto& network : seen.now) {
    const auto text = network.properties.find("unusable");
    const auto list = text == network.properties.end() ? nlohmann::json() : model::parse_json(text->second);
    if (!list.is_array()) continue;
    for (const auto& one : list) {
      if (!one.is_object()) continue;
      all.push_back(
          {"unusable", Grade::kNote,
           fmt::format("network {} of island {}: {} '{}' cannot be used: {}", network.id, name_of(seen.island),
                       model::text_of(one, "address"), model::text_of(one, "name"), model::text_of(one, "why")),
           page("zigbee.md#troubles")});
    }
  }
  return all;
}

Findings check_settings(const IslandSeen& seen) {
  Findings all;
  for (const auto& network : seen.now) {
    const auto text = network.properties.find("settings");
    const auto list = text == network.properties.end() ? nlohmann::json() : model::parse_json(text->second);
    if (!list.is_array()) continue;
    for (const auto& one : list) {
      if (!one.is_object()) continue;
      const auto setting = model::text_of(one, "setting");
      all.push_back({"settings", Grade::kNote,
                     fmt::format("network {} of island {}: {} is {}: {}", network.id, name_of(seen.island), setting,
                                 model::text_of(one, "is"), model::text_of(one, "why")),
                     fmt::format("set {} to {} in the configuration of Zigbee2MQTT and restart it; {}", setting,
                                 model::text_of(one, "should"), page("zigbee.md#what-to-set-in-zigbee2mqtt"))});
    }
  }
  return all;
}

Findings check_brokers(const IslandSeen& seen) {
  Findings all;
  for (const auto& network : seen.now) {
    const auto text = network.properties.find("broker");
    if (text == network.properties.end()) continue;
    const auto broker = model::object_of(text->second);
    const bool tls = model::flag_of(broker, "tls"), user = model::flag_of(broker, "user");
    if (tls && user) continue;
    const auto* lacks = tls ? "a user" : user ? "TLS" : "TLS and without a user";
    all.push_back(
        {"broker", Grade::kNote,
         fmt::format("network {} of island {} uses its MQTT broker without {}: who reaches the broker can read "
                     "and command its devices",
                     network.id, name_of(seen.island), lacks),
         fmt::format("let the broker listen on loopback only, or use TLS and a password; {}",
                     page("zigbee.md#broker-with-tls-and-password"))});
  }
  return all;
}

Findings check_held_back(const IslandSeen& seen) {
  const auto why = seen.properties.find("dds-held-back");
  if (why == seen.properties.end() || why->second.empty()) return {};
  return {{"dds", Grade::kProblem,
           fmt::format("island {} had certificates for DDS ({}), which this release does not have: it does not take "
                       "part by DDS",
                       name_of(seen.island), why->second),
           "choose: a broker with a realm (" + page("sites.md") +
               "), or `tuples: {trust: no}` on a network whose machines are all trusted"}};
}

Findings check_rights(const IslandSeen& seen) {
  const auto refused = seen.numbers.find(kRightsRefused);
  if (refused == seen.numbers.end() || refused->second == 0) return {};
  return {{"rights", Grade::kNote,
           fmt::format("island {} refused {} by its rights since its start", name_of(seen.island),
                       counted(refused->second, "request")),
           "on its host: `rubicon trust audit` lists them, `rubicon trust may NAME RIGHT KEY` names the rule; " +
               page("rights.md")}};
}

Findings check_interfaces_of(const IslandSeen& seen) {
  const auto text = seen.properties.find("dds-interfaces");
  if (text == seen.properties.end()) return {};
  Findings all;
  const auto news = model::object_of(text->second);
  for (const auto& one : news.value("interfaces", nlohmann::json::array())) {
    const auto name = model::text_of(one, "name"), lack = model::text_of(one, "lack");
    if (lack.empty()) continue;
    all.push_back(
        {"interface", Grade::kProblem,
         fmt::format("interface {} of island {} {}: it reaches no other host", name, name_of(seen.island), lack),
         fmt::format("look at its cable or Wi-Fi, and at DHCP: `ip address show dev {}`", name)});
  }
  const auto changes = model::count_of(news, "changes");
  if (changes > 0)
    all.push_back({"interface", Grade::kNote,
                   fmt::format("the addresses of island {} changed {} times since its start, at last at {}",
                               name_of(seen.island), changes, base::local_text(model::time_of(news, "changed"))),
                   "others lose it for some seconds each time: an address that DHCP reserves stays"});
  return all;
}

Finding check_access(const IslandSeen& seen, const client::Options& options) {
  const bool host_only =
      std::all_of(options.interfaces.begin(), options.interfaces.end(), [](const auto& one) { return one == "lo"; });
  const auto id = number(seen.island.id);
  if (seen.numbers.contains(kRightsRefused))
    return {
        "access", Grade::kNote,
        fmt::format("all that reach the interfaces of island {} are the member `lan`; its rights say what `lan` may do",
                    id),
        page("rights.md")};
  const auto remedy = "rights in its configuration say what `lan` may do; " + page("trust.md");
  if (host_only)
    return {"access", Grade::kNote, fmt::format("anybody on this host may read and command island {}", id), remedy};
  return {"access", Grade::kNote,
          fmt::format(
              "every host that reaches the interfaces of island {} can read it; `trust_lan: no` only prevents mistakes",
              id),
          remedy};
}

Finding check_access_of_host(const IslandSeen& seen, const std::string& folder) {
  const auto id = number(seen.island.id);
  if (seen.numbers.contains(kRightsRefused))
    return {"access", Grade::kNote, fmt::format("island {} asks its rights who of this host may do what", id),
            page("rights.md")};
  return {"access", Grade::kNote, fmt::format("whoever may enter {} may read and command island {}", folder, id),
          "rights in its configuration say who may do what; " + page("rights.md")};
}

}  // namespace rubicon::cli
