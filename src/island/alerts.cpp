#include "island/alerts.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <tuple>

#include "model/json_members.h"
#include "model/point_keys.h"

namespace rubicon::island {

namespace {

namespace fs = std::filesystem;

constexpr Duration kPause = std::chrono::seconds(10);

std::optional<std::uint64_t> free_bytes(const std::string& folder) {
  constexpr std::uint64_t kFine = 1'000'000, kCoarse = 100'000'000, kMuch = 1'000'000'000;
  std::error_code error;
  const auto space = fs::space(folder, error);
  if (error) return std::nullopt;
  const std::uint64_t free = space.available;
  return free - free % (free < kMuch ? kFine : kCoarse);
}

}  // namespace

std::optional<std::uint64_t> FreeSpace::beside(const std::string& file) {
  const auto parent = fs::path(file).parent_path();
  const auto folder = parent.empty() ? std::string(".") : parent.string();
  const auto now = scheduler_.now();
  const auto [entry, fresh] = known_.try_emplace(folder);
  auto& known = entry->second;
  if (!fresh && now - known.looked < kPause) return known.bytes;
  known = {now, free_bytes(folder)};
  return known.bytes;
}

namespace {

using model::Alert;
using model::AlertList;
using model::Severity;

constexpr Duration kAlertsPause = std::chrono::seconds(2);
constexpr std::uint64_t kLittleRoom = 100'000'000;  // bytes
constexpr WallTime kEarliest{std::chrono::seconds(1'577'836'800)};

}  // namespace

Alerts::Alerts(Scheduler& scheduler, TupleSpace& space, std::string prefix)
    : scheduler_(scheduler), space_(space), prefix_(std::move(prefix)) {}

void Alerts::publish() {
  timer_ = scheduler_.after(kAlertsPause, [this] { publish(); });
  AlertList list;
  for (const auto& source : sources_) source(list);
  date(list);
  auto text = model::alerts_to_json(list);
  if (text == published_) return;
  published_ = std::move(text);
  std::ignore = space_.set(model::IslandKey{prefix_}.alerts(), published_, {"application/json", {}, {}});
}

/// An alert without a date begins when it was first seen.
void Alerts::date(AlertList& list) {
  const auto before = std::exchange(dates_, {});
  for (auto& one : list.all) {
    if (one.since != WallTime{}) continue;
    const std::pair key(one.kind, one.about);
    const auto known = before.find(key);
    one.since = dates_[key] = known == before.end() ? scheduler_.wall_now() : known->second;
  }
}

void add_disk(const std::string& about, const DiskState& disk, AlertList& list) {
  if (!disk.free || *disk.free >= kLittleRoom) return;
  list.add([&] {
    return Alert{"disk-full",
                 about,
                 Severity::kProblem,
                 {},
                 fmt::format("{} MB are free for {}", *disk.free / 1'000'000, disk.of),
                 "free space on that disk; what cannot be written is lost and counted"};
  });
}

void StateFailures::look(std::uint64_t count, SteadyTime now) {
  if (std::exchange(count_, count) != count) last_ = now;
}

void StateFailures::add(const std::string& about, SteadyTime since, AlertList& list) const {
  if (last_ < since) return;
  list.add([&] {
    return Alert{"not-written",
                 about,
                 Severity::kProblem,
                 {},
                 fmt::format("the state file cannot be written ({} failures)", count_),
                 "the island's log has the reason; what is not written is lost at a restart"};
  });
}

void add_unwritten(const std::string& about, std::string_view status, AlertList& list) {
  const auto tree = model::object_of(status);
  const auto state = model::text_of(tree, "state");
  if (state.empty() || state == "recording" || state == "opening" || state == "stopped") return;
  list.add([&] {
    return Alert{"not-written",
                 about,
                 Severity::kProblem,
                 model::time_of(tree, "since"),
                 fmt::format("{} is not written: {}", model::text_of(tree, "file"), model::text_of(tree, "reason")),
                 "free space on its disk, or correct the configuration; it tries again by itself"};
  });
}

void add_bridge(const std::string& about, std::string_view status, AlertList& list) {
  const auto tree = model::object_of(status);
  const auto reason = model::text_of(tree, "reason");
  if (model::text_of(tree, "state") == "up" || reason.empty())
    return;  // without a reason it connects for the first time
  list.add([&] {
    return Alert{"bridge-down",
                 about,
                 Severity::kProblem,
                 model::time_of(tree, "since"),
                 fmt::format("bridge {} is not connected: {}", model::last_part(about), reason),
                 "check the broker, and what `bridges:` says of it; it tries again by itself"};
  });
}

void add_interfaces(const std::string& about, std::string_view text, AlertList& list) {
  const auto tree = model::object_of(text);
  for (const auto& one : tree.value("interfaces", nlohmann::json::array())) {
    const auto name = model::text_of(one, "name"), lack = model::text_of(one, "lack");
    if (lack.empty()) continue;
    list.add([&] {
      return Alert{"interface-down",
                   about + "." + name,
                   Severity::kProblem,
                   {},
                   fmt::format("interface {} {}: DDS reaches no other host by it", name, lack),
                   fmt::format("look at its cable or Wi-Fi, and at DHCP: `ip address show dev {}`", name)};
    });
  }
}

void add_held_back(const std::string& about, const std::string& why, AlertList& list) {
  if (why.empty()) return;
  list.add([&] {
    return Alert{"held-back",
                 about,
                 Severity::kProblem,
                 {},
                 fmt::format("the island had certificates for DDS ({}), which this release does not have: it does not "
                             "take part by DDS",
                             why),
                 "choose: a broker with a realm, or `tuples: {trust: no}` on a network whose machines are all trusted"};
  });
}

void add_clock(const std::string& about, WallTime now, AlertList& list) {
  if (now >= kEarliest) return;
  list.add([&] {
    return Alert{"clock",
                 about,
                 Severity::kProblem,
                 {},
                 "the clock of this host was never set",
                 "set it: timedatectl set-ntp true"};
  });
}

}  // namespace rubicon::island
