#pragma once

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "base/virtual_scheduler.h"
#include "config/yaml.h"
#include "island/island.h"
#include "scenarios/scripted_network.h"
#include "support/memory/memory_transports.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::scenarios {

using namespace std::chrono_literals;
using tuples::Event;
using tuples::EventKind;
using tuples::Flow;
using tuples::Handle;

/// Islands and other components on one ecology, in virtual time.
class Ecology : public testing::Test {
 public:
  /// An island with one scripted network `scripted-1`; `more` is YAML put under that network.
  island::Island& start_island(std::uint32_t id, const std::string& more = "") {
    const auto text = "island: {id: " + std::to_string(id) + ", name: test}\nnetworks:\n  scripted-1: {type: scripted" +
                      (more.empty() ? "" : ", " + more) + "}\n";
    const auto tree = config::parse_yaml(text, "island.yaml");
    base::ConfigErrors errors;
    auto config = island::read_island_config(tree.value(), std::span(&kScripted, 1), errors);
    auto made = island::Island::make(std::move(config), scheduler, transports, log, ecology, errors);
    EXPECT_TRUE(made.has_value()) << errors.text();
    auto& island = *(islands[id] = std::move(*made));
    island.start();
    scheduler.run_ready();
    return island;
  }

  /// A component that is not an island.
  TupleSpace& component(std::uint32_t id) {
    auto& place = components[id];
    if (!place.space) {
      place.link = ecology.join(OwnerId(id)).value();
      place.space = std::make_unique<TupleSpace>(OwnerId(id), scheduler, *place.link);
      scheduler.run_ready();
    }
    return *place.space;
  }
  void crash(std::uint32_t id) { components.erase(id); }

  ScriptedNetwork& devices_of(std::uint32_t island) { return ScriptedNetwork::of(island, "scripted-1"); }

  model::PointId point(Kind kind, const std::string& type, const std::string& instance = "1") const {
    return {kind, types.find(type)->id, instance};
  }
  model::PointId sensor(const std::string& type) const { return point(Kind::kSensor, type); }
  model::PointId actuator(const std::string& type) const { return point(Kind::kActuator, type); }

  /// A device with a temperature, a light and a switch that reports.
  model::Join lamp() const {
    model::Join join;
    join.name = "Lamp";
    for (const auto* type : {"temperature", "light"}) join.capabilities.push_back(capability(sensor(type)));
    join.capabilities.push_back(capability(actuator("switch"), Access::kReadWrite));
    return join;
  }
  static model::Capability capability(model::PointId point, model::Access access = model::Access::kRead) {
    model::Capability made;
    made.point = std::move(point);
    made.access = access;
    return made;
  }
  using Access = model::Access;

  static model::Updates reading(model::PointId point, Value value, WallTime user = {}) {
    return {{model::Reading{std::move(point), std::move(value), user}}};
  }

  std::string value(TupleSpace& space, std::uint32_t owner, const std::string& key) {
    const auto tuple = space.get(OwnerId(owner), key);
    return tuple ? std::string(tuple->value) : "(none)";
  }
  nlohmann::json json(TupleSpace& space, std::uint32_t owner, const std::string& key) {
    return nlohmann::json::parse(value(space, owner, key), nullptr, false);
  }

  VirtualScheduler scheduler;
  transport::MemoryTransports transports;
  base::NullLogSink log;
  TypeCatalogue types;
  tuples::MemoryEcology ecology{scheduler};

 private:
  struct Place {
    std::unique_ptr<tuples::Link> link;
    std::unique_ptr<TupleSpace> space;
  };

 public:
  std::map<std::uint32_t, std::unique_ptr<island::Island>> islands;
  std::map<std::uint32_t, Place> components;
};

}  // namespace rubicon::scenarios
