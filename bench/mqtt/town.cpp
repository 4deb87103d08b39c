#include "mqtt/town.h"

#include <fmt/format.h>

#include "model/point_tuples.h"
#include "support/config_text.h"

namespace rubicon::bench::mqtt {

namespace {

constexpr OwnerId kTown{6541}, kBridge{70000};

std::string status_of(WallTime heard) {
  std::string text;
  model::write_point_status({"good", "", {}, heard, heard, ""}, text);
  return text;
}

}  // namespace

Town::Town(zigbee::RealRig& rig, int devices) : rig_(rig) {
  island_link_ = must(rig.ecology().join(kTown));
  bridge_link_ = must(rig.ecology().join(kBridge));
  island_ = std::make_unique<TupleSpace>(kTown, rig.scheduler(), *island_link_);
  space_ = std::make_unique<TupleSpace>(kBridge, rig.scheduler(), *bridge_link_);
  must(island_->describe(R"({"name":"town","prefix":"proxy"})"));
  must(island_->set("proxy.wsn.status", R"({"line":"up"})"));
  for (int i = 0; i < devices; ++i) add_device(i);
}

void Town::add_device(int number) {
  const auto device = fmt::format("proxy.wsn.{}", number);
  model::DeviceDescription about;
  about.name = fmt::format("Mote {}", number);
  for (int i = 1; i <= kPoints; ++i) {
    const auto id = fmt::format("temperature-{}", i);
    about.sensors.push_back(id);
    const auto key = fmt::format("{}.sensor.{}", device, id);
    model::PointDescription point;
    point.type = "temperature";
    point.unit = "Cel";
    point.data_type = "real";
    point.access = "read";
    point.report = "state";
    must(island_->set(key + ".description", model::point_description_to_json(point)));
    statuses_.push_back(must(island_->set(key + ".status", status_of(rig_.scheduler().wall_now()))));
    values_.push_back(must(island_->set(key + ".value", "20")));
    topics_.push_back(fmt::format("rubicon/6541/wsn/{}/sensor/{}", number, id));
  }
  must(island_->set(device + ".status", R"({"status":"reachable"})"));
  must(island_->set(device + ".description", model::device_description_to_json(about)));
}

void Town::start_bridge() {
  const auto config = support::config_of(nlohmann::ordered_json{
      {"broker", fmt::format("127.0.0.1:{}", zigbee::kPort)}, {"discovery", "homeassistant"}, {"commands", {"**"}}});
  base::ConfigErrors errors;
  ConfigReader reader(config, "bridges.bench", errors);
  const bridges::BridgeHost host{"bench", rig_.scheduler(), *space_, rig_.transports(), log_, kTown, "proxy"};
  bridge_ = bridges::find_bridge_type("mqtt")->make(reader, "", &host);
  bridge_->start();
}

void Town::read(std::size_t sensor, std::string_view value) {
  must(island_->set(statuses_[sensor], status_of(rig_.scheduler().wall_now())));
  must(island_->set(values_[sensor], value));
}

}  // namespace rubicon::bench::mqtt
