#include <gmock/gmock.h>

#include <map>
#include <random>
#include <set>

#include "networks/zigbee/bridge/bridge_lists.h"

// The inventory against a model that compares whole lists, over random sequences of lists.
namespace rubicon::networks::zigbee::bridge {
namespace {

using namespace std::chrono_literals;

/// What the specification says, without slices, hashes and turns.
struct SimpleModel {
  struct Device {
    TestRecord record;
    bool missing = false;
    SteadyTime since{};
    bool leaving = false;
  };
  std::map<unsigned, Device> devices;
  std::string last;

  void list(const std::string& text, const std::vector<TestRecord>& records, SteadyTime now) {
    if (text == last) return;
    last = text;
    std::set<unsigned> there;
    for (const auto& record : records) {
      there.insert(record.number);
      auto& device = devices[record.number];
      device.missing = device.leaving = false;
      device.record = record;
    }
    std::erase_if(devices, [&](const auto& device) {
      return !there.contains(device.first) && (device.second.leaving || device.second.missing);
    });
    for (auto& [number, device] : devices) {
      if (!there.contains(number)) device.missing = true, device.since = now;
    }
  }
  void leaving(unsigned number) {
    const auto found = devices.find(number);
    if (found == devices.end()) return;
    found->second.leaving = true;
    if (found->second.missing) devices.erase(found);
  }
  void time(SteadyTime now) {
    std::erase_if(devices, [&](const auto& device) {
      return device.second.missing && device.second.since + Presence::kAbsence <= now;
    });
  }
};

class RandomLists {
 public:
  explicit RandomLists(unsigned seed) : random_(seed) {}

  unsigned below(unsigned bound) { return std::uniform_int_distribution<unsigned>(0, bound - 1)(random_); }
  std::vector<TestRecord> records() {
    for (unsigned changes = below(3); changes > 0; --changes) change();
    std::vector<TestRecord> list;
    for (const auto& [number, record] : now_) {
      if (below(12) != 0) list.push_back(record);
    }
    std::shuffle(list.begin(), list.end(), random_);
    if (below(20) == 0) list.clear();
    return list;
  }

 private:
  void change() {
    const auto number = 1 + below(8);
    if (below(4) == 0) {
      now_.erase(number);
      return;
    }
    auto& record = now_[number];
    record.number = number;
    record.name = fmt::format("name {}/{}", number, below(3));
    record.exposes = below(2) == 0 ? kSwitch : kThermometer;
    record.power = below(3) == 0 ? "Battery" : "DC Source";
    record.more = fmt::format(R"(,"network_address":{})", below(4));
  }

  std::mt19937 random_;
  std::map<unsigned, TestRecord> now_;
};

/// What callbacks reported, as a picture of the devices.
struct Picture {
  std::map<std::string, std::string> names;
  int doubled = 0;

  Inventory::Callbacks calls() {
    return {[this](const auto& record) { names[record.address] = record.name + " " + record.leaves[0].name; },
            [this](const auto& address, const auto&) { doubled += names.erase(address) == 1 ? 0 : 1; },
            [this](const auto&, const auto&) { ++doubled; }, [this](const auto&) { ++doubled; }, [] {}};
  }
};

std::map<std::string, std::string> expected(const SimpleModel& model) {
  std::map<std::string, std::string> names;
  for (const auto& [number, device] : model.devices) {
    names[test_address(number)] = device.record.name + (device.record.exposes == kSwitch ? " state" : " temperature");
  }
  return names;
}

TEST(InventoryModel, RandomSequencesOfListsLeadToTheDevicesOfASimpleModel) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    RandomLists random(seed);
    SimpleModel model;
    Picture picture;
    VirtualScheduler scheduler;
    Inventory inventory(scheduler, 100, picture.calls());
    for (int step = 0; step < 100; ++step) {
      if (random.below(6) == 0) {
        const auto number = 1 + random.below(8);
        inventory.leaving(test_address(number));
        model.leaving(number);
      }
      const auto records = random.records();
      const auto text = list_of(records);
      inventory.list(text);
      model.list(text, records, scheduler.now());
      scheduler.run_ready();
      ASSERT_EQ(picture.names, expected(model)) << "seed " << seed << ", step " << step;
      scheduler.run_for(std::chrono::milliseconds(random.below(6'000)));
      model.time(scheduler.now());
      ASSERT_EQ(picture.names, expected(model)) << "seed " << seed << ", after step " << step;
    }
    EXPECT_EQ(picture.doubled, 0);
    EXPECT_EQ(inventory.size(), model.devices.size());
  }
}

}  // namespace
}  // namespace rubicon::networks::zigbee::bridge
