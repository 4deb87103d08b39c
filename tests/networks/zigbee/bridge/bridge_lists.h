#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "base/virtual_scheduler.h"
#include "networks/zigbee/bridge/inventory.h"

namespace rubicon::networks::zigbee::bridge {

/// Recorded material that lies beside the source tree on some machines; empty where it does not.
inline std::string shared_text(const std::string& name) {
  std::ifstream file(RUBICON_SOURCE_DIR "/../shared/data/zigbee/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline std::string test_address(unsigned number) {
  return fmt::format("00124b00{:08x}", number);
}

inline constexpr const char* kSwitch =
    R"([{"type":"switch","features":[{"type":"binary","name":"state","property":"state","access":7,)"
    R"("value_on":"ON","value_off":"OFF","value_toggle":"TOGGLE"}]}])";
inline constexpr const char* kThermometer =
    R"([{"type":"numeric","name":"temperature","property":"temperature","access":1,"unit":"°C"}])";

/// A record of `bridge/devices`.
struct TestRecord {
  unsigned number = 1;
  std::string name = "lamp";
  std::string interview = "SUCCESSFUL";
  std::string type = "Router";
  std::string power = "Mains (single phase)";
  bool supported = true, disabled = false;
  std::string exposes = kSwitch;  ///< empty = no definition
  std::string more{};             ///< further members: `,"network_address":7`

  std::string text() const {
    auto json = fmt::format(R"({{"ieee_address":"0x{}","friendly_name":"{}","type":"{}","interview_state":"{}")",
                            test_address(number), name, type, interview);
    json += fmt::format(R"(,"supported":{},"disabled":{})", supported, disabled);
    if (!power.empty()) json += fmt::format(R"(,"power_source":"{}")", power);
    if (!exposes.empty())
      json += fmt::format(R"(,"definition":{{"vendor":"V","model":"M","description":"D","exposes":{}}})", exposes);
    return json + more + "}";
  }
};

inline constexpr const char* kCoordinatorRecord =
    R"({"ieee_address":"0x00124b00deadbeef","friendly_name":"Coordinator","type":"Coordinator","supported":true,)"
    R"("interview_state":"SUCCESSFUL"})";

inline std::string list_of_texts(const std::vector<std::string>& records) {
  std::string list = "[";
  list += kCoordinatorRecord;
  for (const auto& record : records) list += "," + record;
  return list + "]";
}

inline std::string list_of(const std::vector<TestRecord>& records) {
  std::vector<std::string> texts;
  for (const auto& record : records) texts.push_back(record.text());
  return list_of_texts(texts);
}

/// An inventory in virtual time; writes down what it calls.
struct ObservedInventory {
  explicit ObservedInventory(std::size_t most_devices = 1000)
      : inventory(
            scheduler, most_devices,
            {[this](const auto& record) { note("changed", record.address, record.name); },
             [this](const auto& address, const auto& reason) { note("left", address, reason); },
             [this](const auto& record, const auto& why) { note("waiting", record.address, why); },
             [this](const Error& error) { events.push_back("unreadable: " + error.text); }, [this] { ++compared; }}) {}

  void note(const char* what, const std::string& address, const std::string& text) {
    events.push_back(fmt::format("{} {}: {}", what, address.substr(14), text));
    if (const auto call = std::exchange(on_first_call, {})) call();
  }
  /// What happens because of this list.
  std::vector<std::string> list(const std::string& payload) {
    inventory.list(payload);
    return run();
  }
  std::vector<std::string> run() {
    scheduler.run_ready();
    return std::exchange(events, {});
  }
  std::vector<std::string> run_for(Duration span) {
    scheduler.run_for(span);
    return std::exchange(events, {});
  }

  VirtualScheduler scheduler;
  std::vector<std::string> events;
  std::function<void()> on_first_call;  ///< inside the next call of the inventory
  int compared = 0;
  Inventory inventory;
};

}  // namespace rubicon::networks::zigbee::bridge
