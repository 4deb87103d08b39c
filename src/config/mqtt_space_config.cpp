#include "config/mqtt_space_config.h"

#include <fmt/format.h>

#include <filesystem>

#include "transport/mqtt_tls.h"

namespace rubicon::config {

namespace {

constexpr const char* kRealmFile = "realm.p7s";
constexpr Duration kMaxBrokerLease = std::chrono::minutes(10);

void check_user(ConfigReader& mqtt, const transport::MqttOptions& line) {
  if (line.user.empty()) return;
  if (const auto good = tuples::mqtt::check_user(line.user); !good) mqtt.error("broker", good.error().text);
}

}  // namespace

MqttSpaceSetup read_mqtt_space(ConfigReader& tuples, const std::string& directory) {
  MqttSpaceSetup setup;
  auto mqtt = tuples.map("mqtt");
  setup.broker = transport::read_mqtt_broker(mqtt, directory);
  check_user(mqtt, setup.broker.line);
  setup.space = mqtt.text("space", setup.space);
  if (!tuples::mqtt::is_space(setup.space)) mqtt.error("space", "expected 1 to 64 of A-Z a-z 0-9 . _ -");
  setup.lease = mqtt.duration("lease", setup.lease);
  if (setup.lease < tuples::mqtt::kMinLease || setup.lease > kMaxBrokerLease)
    mqtt.error("lease", "expected from 13s to 10min: a broker notices a silent connection only so late");
  setup.trust_broker = mqtt.boolean("trust_broker", setup.trust_broker);
  mqtt.finish();
  return setup;
}

Result<tuples::mqtt::SpaceOptions> MqttSpaceSetup::options(transport::Transports& transports) const {
  auto line = broker.with_password(transports);
  if (!line) return fail(std::move(line.error()));
  tuples::mqtt::SpaceOptions found;
  found.broker = std::move(*line);
  if (!found.broker.user.empty()) {
    found.user = found.broker.user;
  } else if (found.broker.tls && !found.broker.tls->certificate_file.empty()) {
    auto name = transport::certificate_name(found.broker.tls->certificate_file);
    if (!name) return fail(std::move(name.error()));
    found.user = std::move(*name);
  }
  found.space = space;
  found.lease = lease;
  found.trust_broker = trust_broker;
  return found;
}

std::string MqttSpaceSetup::realm_folder() const {
  const auto& tls = broker.line.tls;
  if (!tls || tls->ca_file.empty()) return {};
  const auto folder = std::filesystem::path(tls->ca_file).parent_path();
  std::error_code none;
  return std::filesystem::exists(folder / kRealmFile, none) ? folder.string() : std::string();
}

}  // namespace rubicon::config
