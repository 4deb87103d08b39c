#include <fmt/format.h>

#include <stdexcept>

#include "frame/process_figures.h"
#include "networks/zigbee/bridge/inventory.h"
#include "zigbee/records.h"
#include "zigbee/rig.h"

namespace rubicon::bench::zigbee {

namespace {

using namespace std::chrono_literals;
using networks::zigbee::bridge::DeviceRecord;
using networks::zigbee::bridge::Inventory;

constexpr int kRepeats = 20;

/// An inventory whose turns are timed.
class Lists {
 public:
  Lists()
      : inventory_(time_, 20'000,
                   {[](const DeviceRecord&) {}, [](const std::string&, const std::string&) {},
                    [](const DeviceRecord&, const std::string&) {},
                    [](const Error& error) { throw std::runtime_error(error.text); }, [this] { ++compared_; }}) {}

  /// Gives the list and runs until it is compared. Milliseconds of processor time.
  double give(const std::string& list) {
    const auto before = thread_seconds();
    time_.run([&] { inventory_.list(list); });
    virtual_time_.run_for(1ms);
    if (compared_ != ++given_) throw std::runtime_error("a list was not compared");
    return (thread_seconds() - before) * 1e3;
  }
  double longest_ms() const { return time_.longest_ms(); }
  void forget() { time_.forget(); }
  const Inventory& inventory() const { return inventory_; }

 private:
  VirtualScheduler virtual_time_;
  TimedScheduler time_{virtual_time_};
  Inventory inventory_;
  int given_ = 0, compared_ = 0;
};

Json one_list(const Plan& plan, const std::vector<std::string>& records) {
  auto changed = records;
  changed[changed.size() / 2] = renamed(changed[changed.size() / 2], "kitchen lamp");
  const auto one = list_of(records, records.size()), other = list_of(changed, changed.size());
  std::vector<double> first, same, differs, longest;
  for (int round = 0; round < plan.rounds; ++round) {
    Lists lists;
    first.push_back(lists.give(one));
    lists.forget();
    for (int i = 0; i < kRepeats; ++i) same.push_back(lists.give(one));
    for (int i = 0; i < kRepeats; ++i) differs.push_back(lists.give(i % 2 == 0 ? other : one));
    longest.push_back(lists.longest_ms());
    if (lists.inventory().size() != records.size()) throw std::runtime_error("the inventory lost devices");
  }
  return {{"bytes", one.size()},
          {"devices", records.size()},
          {"first_ms", rounded(median(first), 2)},
          {"unchanged_ms", rounded(median(same), 3)},
          {"one_changed_ms", rounded(median(differs), 2)},
          {"one_changed_worst_ms", rounded(percentile(differs, 1), 2)},
          {"longest_turn_ms", rounded(median(longest), 2)}};
}

/// The lists of a mass join: each device appears, is interviewed, and has its definition; `lists` in all.
template <class Give>
std::uint64_t burst(const Plan& plan, std::vector<std::string> records, Give give) {
  std::uint64_t bytes = 0;
  const auto devices = static_cast<int>(records.size());
  const auto whole = records;
  for (int i = 0; i < plan.lists; ++i) {
    const auto known = static_cast<std::size_t>(static_cast<std::int64_t>(i) * devices / plan.lists);
    const bool joined = static_cast<std::int64_t>(i + 1) * devices / plan.lists > static_cast<std::int64_t>(known);
    records[known] = joined ? whole[known] : interviewing(whole[known]);
    if (!joined && i % 2 == 1) records[known] = renamed(records[known], name_of(whole[known]) + " ");
    const auto list = list_of(records, known + 1);
    bytes += list.size();
    give(list);
  }
  return bytes;
}

/// Every list is compared: none is replaced by the next.
Json inventory_burst(const Plan& plan, const std::vector<std::string>& records) {
  Lists lists;
  double spent = 0;
  const auto bytes = burst(plan, records, [&](const std::string& list) { spent += lists.give(list) / 1e3; });
  return {{"lists", plan.lists},
          {"mb", rounded(static_cast<double>(bytes) / 1e6, 1)},
          {"processor_s", rounded(spent, 2)},
          {"longest_turn_ms", rounded(lists.longest_ms(), 2)}};
}

/// The same through an island, up to the tuples of the devices.
Json island_burst(const Plan& plan, const std::vector<std::string>& records) {
  VirtualRig rig;
  rig.begin(list_of(records, 0));
  forget_peak();
  const auto before = resident_mb();
  rig.time.forget();
  double spent = 0;
  burst(plan, records, [&](const std::string& list) {
    const auto start = thread_seconds();
    rig.say("zigbee2mqtt/bridge/devices", list);
    rig.virtual_time.run_for(20ms);
    spent += thread_seconds() - start;
  });
  rig.virtual_time.run_for(5s);
  const auto joined = listed_devices(*rig.island).size();
  if (joined != records.size())
    throw std::runtime_error(fmt::format("{} of {} devices joined", joined, records.size()));
  return {{"processor_s", rounded(spent, 2)},
          {"longest_turn_ms", rounded(rig.time.longest_ms(), 2)},
          {"resident_growth_mb", rounded(resident_mb() - before, 1)},
          {"peak_growth_mb", rounded(peak_mb() - before, 1)}};
}

}  // namespace

void measure_lists(const Plan& plan, Json& out) {
  const auto records = device_records(plan.devices);
  out["list"] = one_list(plan, records);
  out["burst"] = inventory_burst(plan, records);
  out["burst_island"] = island_burst(plan, records);
}

}  // namespace rubicon::bench::zigbee
