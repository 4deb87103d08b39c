#include "config/mqtt_space_config.h"

#include <fmt/format.h>

#include <filesystem>

#include "base/printable.h"
#include "transport/mqtt_tls.h"

namespace rubicon::config {

namespace {

constexpr const char* kRealmFile = "realm.p7s";
constexpr std::size_t kMaxSpare = 8;
constexpr Duration kMaxBrokerLease = std::chrono::minutes(10);

void check_user(ConfigReader& mqtt, const transport::MqttOptions& line) {
  if (line.user.empty()) return;
  if (const auto good = tuples::mqtt::check_user(line.user); !good) mqtt.error("broker", good.error().text);
}

std::vector<base::HostPort> read_spare(ConfigReader& mqtt, std::uint16_t port) {
  std::vector<base::HostPort> spare;
  for (const auto& text : mqtt.texts("spare_brokers")) {
    const auto address = base::parse_host_port(text, port);
    if (address && !address->host.empty()) {
      spare.push_back(*address);
    } else {
      mqtt.error("spare_brokers", fmt::format("has '{}', expected HOST[:PORT]", base::one_line(text.substr(0, 60))));
    }
  }
  if (spare.size() > kMaxSpare) mqtt.error("spare_brokers", fmt::format("expected at most {}", kMaxSpare));
  return spare;
}

}  // namespace

MqttSpaceSetup read_mqtt_space(ConfigReader& tuples, const std::string& directory) {
  MqttSpaceSetup setup;
  auto mqtt = tuples.map("mqtt");
  setup.broker = transport::read_mqtt_broker(mqtt, directory);
  check_user(mqtt, setup.broker.line);
  setup.spare = read_spare(mqtt, setup.broker.line.port);
  setup.space = mqtt.text("space", setup.space);
  if (!tuples::mqtt::is_space(setup.space)) mqtt.error("space", "expected 1 to 64 of A-Z a-z 0-9 . _ -");
  setup.lease = mqtt.duration("lease", setup.lease);
  if (setup.lease < tuples::mqtt::kMinLease || setup.lease > kMaxBrokerLease)
    mqtt.error("lease", "expected from 13s to 10min: a broker notices a silent connection only so late");
  setup.trust_broker = mqtt.boolean("trust_broker", setup.trust_broker);
  setup.watch_all = mqtt.choice("watch", "met", {"met", "all"}) == "all";
  mqtt.finish();
  return setup;
}

Result<tuples::mqtt::SpaceOptions> MqttSpaceSetup::options(transport::Transports& transports) const {
  auto line = broker.with_password(transports);
  if (!line) return fail(std::move(line.error()));
  tuples::mqtt::SpaceOptions found;
  tuples::mqtt::SpaceBroker first{std::move(*line)};
  if (!first.line.user.empty()) {
    first.user = first.line.user;
  } else if (first.line.tls && !first.line.tls->certificate_file.empty()) {
    auto name = transport::certificate_name(first.line.tls->certificate_file);
    if (!name) return fail(std::move(name.error()));
    first.user = std::move(*name);
  }
  found.brokers = tuples::mqtt::with_spare(std::move(first), spare);
  found.space = space;
  found.lease = lease;
  found.trust_broker = trust_broker;
  found.watch_all = watch_all;
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
