#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "config/yaml.h"
#include "contract/peers.h"
#include "island/network_types.h"
#include "network-template/template_network.h"
#include "proxy/tuple_text.h"
#include "support/fake_host.h"
#include "transport/local_transports.h"

namespace rubicon {
namespace {

using namespace std::chrono_literals;

/// Where a network of one type has a sensor or actuator of a physical quantity.
struct Place {
  std::string_view quantity, device;
  Kind kind = Kind::kSensor;
  std::string_view type{};  ///< only where a device has several of the kind
};

struct Offer {
  std::string_view network;
  std::string_view yaml;
  std::vector<Place> places;
};

const std::vector<Offer>& offers() {
  static const std::vector<Offer> kOffers{
      {"dummy",
       "simulate:\n"
       "  air: {sensors: {temperature-1: {}}}\n"
       "  sill: {sensors: {light-1: {}}}\n"
       "  old-sill: {sensors: {illuminance-1: {}}}\n"
       "  hall: {sensors: {motion-1: {}}}\n"
       "  old-hall: {sensors: {pir-1: {}}}\n"
       "  bath: {sensors: {humidity-1: {}}}\n"
       "  door: {sensors: {contact-1: {}}}\n"
       "  fridge: {sensors: {power-1: {}}}\n"
       "  barometer: {sensors: {airPressure-1: {}}}\n"
       "  key: {sensors: {switch-1: {}}, actuators: {switch-1: {}}}\n"
       "  ceiling: {actuators: {lamp-1: {}}}\n"
       "  shade: {actuators: {blindPosition-1: {}}}\n"
       "  socket: {actuators: {relay-1: {}}}\n",
       {{"temperature", "air"},
        {"illuminance", "sill"},
        {"illuminance", "old-sill"},
        {"motion", "hall"},
        {"motion", "old-hall"},
        {"humidity", "bath"},
        {"door", "door"},
        {"power", "fridge"},
        {"air pressure", "barometer"},
        {"switch state", "key"},
        {"switch", "key", Kind::kActuator},
        {"lamp", "ceiling", Kind::kActuator},
        {"blinds", "shade", Kind::kActuator},
        {"relay", "socket", Kind::kActuator}}},
      {"knx",
       "via: tunnel\n"
       "host: 192.168.1.10\n"
       "groups:\n"
       "  1/2/1: 9.001\n"
       "  1/2/2: 14.068\n"
       "  1/2/3: 9.027\n"
       "  1/2/4: 9.004\n"
       "  1/2/5: 7.013\n"
       "  1/2/6: 9.007\n"
       "  1/2/7: 1.019\n"
       "  1/2/8: 14.056\n"
       "  1/2/9: 9.024\n"
       "  1/2/10: {dpt: 1.001, kind: sensor}\n"
       "  1/2/11: {dpt: 1.001, kind: actuator}\n",
       {{"temperature", "1/2/1"},
        {"temperature", "1/2/2"},
        {"temperature", "1/2/3"},
        {"illuminance", "1/2/4"},
        {"illuminance", "1/2/5"},
        {"humidity", "1/2/6"},
        {"door", "1/2/7"},
        {"power", "1/2/8"},
        {"power", "1/2/9"},
        {"switch state", "1/2/10"},
        {"switch", "1/2/11", Kind::kActuator}}},
      {"log",
       "format: csv\n"
       "file: recordings/flat_day.csv\n"
       "comment: \"#\"\n"
       "time: {column: time, unit: iso}\n"
       "map:\n"
       "  air: {columns: {kitchen_temperature: {sensor: temperature-1}}}\n"
       "  fahrenheit: {columns: {bathroom_temperature: {sensor: temperature-1, unit: \"[degF]\"}}}\n"
       "  sill: {columns: {living_light: {sensor: light-1}}}\n"
       "  hall: {columns: {living_motion: {sensor: motion-1}}}\n"
       "  bath: {columns: {kitchen_humidity: {sensor: humidity-1}}}\n"
       "  door: {columns: {entrance_door: {sensor: contact-1}}}\n"
       "  fridge: {columns: {fridge_power: {sensor: power-1, unit: kW}}}\n"
       "  barometer: {columns: {kitchen_co2: {sensor: airPressure-1, unit: hPa}}}\n",
       {{"temperature", "air"},
        {"temperature", "fahrenheit"},
        {"illuminance", "sill"},
        {"motion", "hall"},
        {"humidity", "bath"},
        {"door", "door"},
        {"power", "fridge"},
        {"air pressure", "barometer"}}},
      {"salad",
       "salad_host: localhost\n"
       "salad_port: 9000\n"
       "rubicon_port: 9100\n"
       "table:\n"
       "  7: [FRIDGE, sensor.switch]\n"
       "  44: [KNX_DOORBELL, sensor.motion]\n"
       "  46: [KNX_LIGHT_ENTRANCE, actuator.light, 1/1/1]\n"
       "  65: [SOCKET, actuator.relay, 1/1/2]\n",
       {{"switch state", "7"}, {"motion", "44"}, {"lamp", "46", Kind::kActuator}, {"relay", "65", Kind::kActuator}}},
      {"wsn",
       "source: \"serial@/dev/ttyUSB0:telosb\"\n"
       "board: EM1000\n"
       "boards: {5: SE1000}\n",
       {{"temperature", "2", Kind::kSensor, "temperature"},
        {"illuminance", "2", Kind::kSensor, "light"},
        {"humidity", "2", Kind::kSensor, "humidity"},
        {"motion", "5", Kind::kSensor, "motion"}}},
      // the built-in models of the simulator, in its order
      {"zigbee",
       "broker: localhost\n",
       {{"temperature", "00124b0010000002", Kind::kSensor, "temperature"},
        {"humidity", "00124b0010000002", Kind::kSensor, "humidity"},
        {"motion", "00124b0010000003", Kind::kSensor, "motion"},
        {"illuminance", "00124b0010000003", Kind::kSensor, "light"},
        {"door", "00124b0010000004", Kind::kSensor, "contact"},
        {"power", "00124b0010000001", Kind::kSensor, "power"},
        {"air pressure", "00124b001000000b", Kind::kSensor, "airPressure"},
        {"switch", "00124b001000000a", Kind::kActuator, "switch"},
        {"lamp", "00124b0010000000", Kind::kActuator, "lamp"},
        {"blinds", "00124b0010000005", Kind::kActuator, "blindPosition"}}},
      {"template",
       "device: lamp\n"
       "temperature: 21.5\n",
       {{"temperature", "lamp"}, {"switch", "lamp", Kind::kActuator}}}};
  return kOffers;
}

std::vector<network::NetworkType> catalogue_types() {
  const auto built_in = island::network_types();
  std::vector<network::NetworkType> types(built_in.begin(), built_in.end());
  types.push_back(networks::template_network::kType);
  return types;
}

/// One network that runs beside its peer, and what it says of its devices.
class Running {
 public:
  Running(const network::NetworkType& type, const Offer& offer) {
    auto options = config::parse_yaml(offer.yaml, "offer.yaml");
    EXPECT_TRUE(options) << options.error().text;
    if (!options) return;
    options_ = std::move(*options);
    host_.lines = &lines_;
    peer_ = contract::peer_of(type.name, options_, types_, host_);
    ConfigReader reader(options_, "networks." + std::string(type.name), errors_);
    auto made = type.make({std::string(type.name), IslandId{1}, reader, types_, examples()}, host_);
    reader.finish();
    EXPECT_TRUE(made && errors_.empty()) << errors_.text();
    if (!made) return;
    network_ = std::move(*made);
    EXPECT_TRUE(network_->open());
    host_.time.run_for(30s);
  }

  /// What the tuples say of a point, without its instance; empty = there is not exactly one.
  std::string description(const Place& place) const {
    std::vector<Capability> fit;
    for (const auto& [device, join] : host_.all<model::Join>()) {
      if (device != place.device) continue;
      fit.clear();  // the list is complete
      for (const auto& one : join.capabilities) {
        const auto* type = types_.find(one.point.type);
        const bool meant = place.type.empty() || (type && type->name == place.type);
        if (one.point.kind == place.kind && meant) fit.push_back(one);
      }
    }
    if (fit.size() != 1) return {};
    proxy::Point point;
    point.id = fit[0].point;
    point.details = std::make_unique<proxy::PointDetails>();
    point.details->capability = std::make_shared<const proxy::PointCapability>(fit[0], types_);
    point.details->name("it-1");
    point.type = point.details->capability->type;
    return proxy::point_description(point);
  }

 private:
  static std::string examples() { return std::string(RUBICON_SOURCE_DIR) + "/examples"; }

  ConfigNode options_;
  ConfigErrors errors_;
  TypeCatalogue types_;
  transport::LocalTransports disk_;
  support::FakeHost host_;
  contract::DiskAndMemory lines_{disk_, host_.files};
  std::unique_ptr<contract::Peer> peer_;
  std::unique_ptr<network::Network> network_;
};

struct Described {
  std::string where, text;
};

std::map<std::string_view, std::vector<Described>> all_descriptions() {
  std::map<std::string_view, std::vector<Described>> all;
  for (const auto& type : catalogue_types()) {
    const auto offer =
        std::find_if(offers().begin(), offers().end(), [&](const Offer& one) { return one.network == type.name; });
    EXPECT_NE(offer, offers().end()) << "say which quantities a network of type " << type.name << " has";
    if (offer == offers().end()) continue;
    const Running network(type, *offer);
    for (const auto& place : offer->places) {
      auto text = network.description(place);
      EXPECT_FALSE(text.empty()) << type.name << " has no " << place.quantity << " at " << place.device;
      all[place.quantity].push_back({std::string(type.name) + " " + std::string(place.device), std::move(text)});
    }
  }
  return all;
}

TEST(Quantities, AreDescribedAlikeByAllNetworksPairByPair) {
  const auto all = all_descriptions();
  for (const auto& [quantity, described] : all) {
    std::set<std::string> networks;
    for (const auto& one : described) networks.insert(one.where.substr(0, one.where.find(' ')));
    EXPECT_GE(networks.size(), 2u) << quantity;
    for (std::size_t i = 0; i < described.size(); ++i) {
      for (std::size_t j = i + 1; j < described.size(); ++j) {
        EXPECT_EQ(described[i].text, described[j].text)
            << quantity << ": " << described[i].where << " and " << described[j].where;
      }
    }
  }
}

TEST(Quantities, ADescriptionHasWhatIsCompared) {
  const auto all = all_descriptions();
  for (const auto* quantity : {"temperature", "illuminance", "humidity"}) {
    const auto tree = nlohmann::json::parse(all.at(quantity).at(0).text);
    for (const auto* field : {"type", "type_id", "unit", "data_type", "minimum", "maximum", "access", "report"})
      EXPECT_TRUE(tree.contains(field)) << quantity << ": " << field;
  }
  const auto light = nlohmann::json::parse(all.at("illuminance").at(0).text);
  EXPECT_EQ(light["type"], "light");
  EXPECT_EQ(light["type_id"], 1);
  EXPECT_EQ(nlohmann::json::parse(all.at("motion").at(0).text)["type_id"], 10);
}

}  // namespace
}  // namespace rubicon
