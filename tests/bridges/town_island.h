#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "model/point_tuples.h"
#include "model/type_catalogue.h"
#include "rubicon/summary.hpp"
#include "rubicon/tuple_space.hpp"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::bridges {

using nlohmann::json;

/// A point as an island describes it.
struct Described {
  std::string kind, id;  ///< `sensor`, `temperature-1`
  std::string value{};
  std::string quality = "good";
  std::vector<std::string> words{};  ///< of the device; empty = those of the type
  std::string access{};              ///< empty = by kind
};

/// An island as others see it: its tuples are what the test says, and commands to them are kept.
class TownIsland {
 public:
  TownIsland(tuples::MemoryEcology& ecology, Scheduler& time, OwnerId id, const std::string& name)
      : time_(time), link_(ecology.join(id).value()), space(id, time, *link_) {
    EXPECT_TRUE(space.describe(model::to_json(Summary{name, "hall", "rubicon-proxy 9", "proxy", time.wall_now()})));
    policy_ = space.add_policy(Pattern::parse("proxy.**").value(), [this](const tuples::RemoteSet& set) {
      sets.push_back(set);
      if (!refuses.empty()) return tuples::SetDecision::refused({ErrorCode::kRefused, refuses});
      return tuples::SetDecision::consumed();
    });
  }
  void network(const std::string& id, const std::string& line = "up") {
    put("proxy." + id + ".status", json{{"line", line}, {"reason", ""}, {"since", 1}}.dump());
  }
  /// With its network; `network.device`.
  void device(const std::string& at, const std::string& name, const std::vector<Described>& points,
              const std::string& area = {}, const std::string& status = "reachable") {
    model::DeviceDescription about;
    about.name = name;
    about.address = at.substr(at.rfind('.') + 1);
    about.area = area;
    about.model = "M1";
    for (const auto& point : points) {
      auto& ids = point.kind == "sensor"     ? about.sensors
                  : point.kind == "actuator" ? about.actuators
                                             : about.properties;
      ids.push_back(point.id);
    }
    put("proxy." + at + ".description", model::device_description_to_json(about));
    reach(at, status);
    for (const auto& point : points) this->point(at, point);
  }
  void reach(const std::string& at, const std::string& status) {
    put("proxy." + at + ".status", json{{"status", status}, {"reason", ""}, {"since", 1}}.dump());
  }
  void point(const std::string& at, const Described& point) {
    const auto key = fmt::format("proxy.{}.{}.{}", at, point.kind, point.id);
    const auto* type = types_.find(point.id.substr(0, point.id.find('-')));
    ASSERT_NE(type, nullptr) << point.id;
    model::PointDescription about;
    about.type = type->name;
    about.unit = type->unit;
    about.data_type = to_string(type->data);
    if (std::isfinite(type->minimum)) about.minimum = type->minimum;
    if (std::isfinite(type->maximum)) about.maximum = type->maximum;
    about.words = model::words_in(type->words);
    if (!point.words.empty()) about.words.clear();
    for (const auto& word : point.words) about.words.push_back({static_cast<std::uint32_t>(about.words.size()), word});
    about.access = !point.access.empty() ? point.access : point.kind == "sensor" ? "read" : "read-write";
    about.report = type->report == model::Report::kEvent ? "event" : "state";
    put(key + ".description", model::point_description_to_json(about));
    say(at, point);
  }
  void say(const std::string& at, const Described& point) {
    const auto key = fmt::format("proxy.{}.{}.{}", at, point.kind, point.id);
    std::string status;
    model::write_point_status({point.quality, "", {}, time_.wall_now(), {}, command, ended}, status);
    put(key + ".status", status);
    put(key + ".value", point.value);
  }
  void put(const std::string& key, const std::string& value) { ASSERT_TRUE(space.set(key, value)) << key; }
  void remove_device(const std::string& at) { space.erase(Pattern::parse("proxy." + at + ".**").value()); }
  /// The state of the last command of a point.
  void report(const std::string& at, const Described& point, const std::string& state, const std::string& reason = {}) {
    model::CommandStatus told;
    told.state = state;
    told.reason = reason;
    told.commander = {sets.back().from, "bridge", sets.back().request};
    command = model::command_status_to_json(told);
    say(at, point);
    command.clear();
  }

  std::vector<tuples::RemoteSet> sets;
  std::string refuses;  ///< not empty: each set, with this reason

 private:
  Scheduler& time_;
  std::unique_ptr<tuples::Link> link_;

 public:
  TupleSpace space;
  std::string command, ended;

 private:
  Handle policy_;
  TypeCatalogue types_;
};

}  // namespace rubicon::bridges
