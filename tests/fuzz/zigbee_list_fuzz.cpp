#include <cstdlib>
#include <map>

#include "base/virtual_scheduler.h"
#include "fuzz_target.h"
#include "networks/zigbee/bridge/inventory.h"

namespace rubicon::fuzz::zigbee_list_fuzz {

namespace {

using namespace rubicon::networks::zigbee::bridge;

constexpr std::size_t kMaxDeviceCount = 6;

void check(bool holds) {
  if (!holds) std::abort();
}

/// Which devices the calls say are there: usable or not.
struct Said {
  std::map<std::string, bool> usable;

  void there(const DeviceRecord& record, bool can_be_used) {
    check(record.address.size() == 16 && (name_problem(record.name).empty() || !record.unusable_name.empty()) &&
          record.role != Role::kCoordinator);
    check(why_waiting(record).empty() == can_be_used);
    usable[record.address] = can_be_used;
  }
  void left(const std::string& address) { check(usable.erase(address) == 1); }
};

}  // namespace

/// Input: payloads of bridge/devices, separated by lines that are empty. Between them three seconds pass. What the
/// calls say and what the inventory holds are the same.
FUZZ_TARGET(zigbee_list) {
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  VirtualScheduler scheduler;
  Said said;
  Inventory inventory(scheduler, kMaxDeviceCount,
                      {[&](const auto& record) { said.there(record, true); },
                       [&](const auto& address, const auto& reason) {
                         check(!reason.empty());
                         said.left(address);
                       },
                       [&](const auto& record, const auto& why) {
                         check(!why.empty());
                         said.there(record, false);
                       },
                       [](const Error& error) { check(!error.text.empty()); }, [] {}});
  while (!rest.empty()) {
    const auto end = std::min(rest.find("\n\n"), rest.size());
    inventory.list(rest.substr(0, end));
    if (end % 3 == 0 && !said.usable.empty()) inventory.leaving(said.usable.begin()->first);
    if (end % 7 == 0) inventory.line_lost();
    scheduler.run_for(std::chrono::seconds(3));
    rest.remove_prefix(std::min(end + 2, rest.size()));
    std::map<std::string, bool> held;
    inventory.each([&](const auto& record, const auto& why) { held[record.address] = why.empty(); });
    check(held == said.usable && held.size() <= kMaxDeviceCount);
  }
  return 0;
}

}  // namespace rubicon::fuzz::zigbee_list_fuzz
