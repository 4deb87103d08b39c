#include "contract/peers.h"

#include <gtest/gtest.h>

#include "apps/simulators/motes/world.h"
#include "apps/simulators/salad/simulator.h"
#include "apps/simulators/zigbee/simulator.h"
#include "support/knx_server.h"
#include "support/memory/mqtt_broker.h"

namespace rubicon::contract {

namespace {

using namespace std::chrono_literals;

class SaladPeer final : public Peer {
 public:
  SaladPeer(const ConfigNode& options, const TypeCatalogue& types, support::FakeHost& host) {
    base::ConfigErrors errors;
    ConfigReader reader(options, "", errors);
    auto read = networks::salad::read_salad_options({"salad", IslandId{1}, reader, types, {}}, host.files);
    simulator_ = std::make_unique<salad_simulator::Simulator>(
        salad_simulator::SimulatorOptions{}, std::move(read.devices), std::vector<salad_simulator::Step>{}, types,
        host.time, host.files, Log(host.words, "simulator"));
    EXPECT_TRUE(simulator_->open());
  }

 private:
  std::unique_ptr<salad_simulator::Simulator> simulator_;
};

/// A KNXnet/IP server where the options say that it is.
class KnxPeer final : public Peer {
 public:
  KnxPeer(const ConfigNode& options, support::FakeHost& host) : server_(host.time, host.net, server_options(options)) {
    server_.answers[0x0a07] = {{0x0c, 0x33}, false};  // 1/2/7 of the sample: 21.5 degrees Celsius
  }

 private:
  static support::KnxServer::Options server_options(const ConfigNode& options) {
    support::KnxServer::Options out;
    if (const auto* at = options.find("host")) out.at.address = at->text;
    return out;
  }
  support::KnxServer server_;
};

/// A sink with three motes, and a fourth of a board that detects motion, where the sample's serial line is.
class MotesPeer final : public Peer {
 public:
  explicit MotesPeer(support::FakeHost& host) : world_(options(), host.time) {
    EXPECT_TRUE(world_.open(1, [&host](motes_simulator::SinkPort& port) -> Result<std::shared_ptr<void>> {
      port.attach(host.files.serial().plug("/dev/ttyUSB0", port.calls()));
      return std::make_shared<int>(0);
    }));
  }

 private:
  static motes_simulator::WorldOptions options() {
    motes_simulator::WorldOptions out;
    motes_simulator::MoteOptions mote;
    mote.board = motes_simulator::parse_build("EM1000").value();
    out.sink.island = 1;  // they may be switched on before the computer comes
    out.add_motes(1, 2, 3, mote);
    mote.board = motes_simulator::parse_build("SE1000").value();
    out.add_motes(1, 5, 1, mote);
    return out;
  }
  motes_simulator::World world_;
};

/// A bridge with a device of each built-in model, and the broker between it and the network.
class ZigbeePeer final : public Peer {
 public:
  explicit ZigbeePeer(support::FakeHost& host)
      : broker_(host.net, {"127.0.0.1", 1883}),
        world_(options(), host.time, Log(host.words, "bridge")),
        line_(world_, at_home(), host.time, host.files, Log(host.words, "bridge")) {
    for (const auto& name : zigbee_simulator::model_names())
      EXPECT_TRUE(world_.add(zigbee_simulator::find_model(name).value(), name));
    EXPECT_TRUE(line_.open());
    host.time.run_for(1s);
  }

 private:
  static zigbee_simulator::WorldOptions options() {
    zigbee_simulator::WorldOptions out;
    out.every = 10s;
    return out;
  }
  static transport::MqttOptions at_home() {
    transport::MqttOptions out;
    out.host = "localhost";
    return out;
  }
  transport::MqttBroker broker_;
  zigbee_simulator::World world_;
  zigbee_simulator::BrokerLine line_;
};

}  // namespace

std::unique_ptr<Peer> peer_of(std::string_view type, const ConfigNode& options, const TypeCatalogue& types,
                              support::FakeHost& host) {
  if (type == "salad") return std::make_unique<SaladPeer>(options, types, host);
  if (type == "wsn") return std::make_unique<MotesPeer>(host);
  if (type == "zigbee") return std::make_unique<ZigbeePeer>(host);
  if (type == "knx") return std::make_unique<KnxPeer>(options, host);
  return nullptr;
}

}  // namespace rubicon::contract
