#include "contract/peers.h"

#include <gtest/gtest.h>

#include "apps/salad-simulator/simulator.h"

namespace rubicon::contract {

namespace {

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

}  // namespace

std::unique_ptr<Peer> peer_of(std::string_view type, const ConfigNode& options, const TypeCatalogue& types,
                              support::FakeHost& host) {
  if (type == "salad") return std::make_unique<SaladPeer>(options, types, host);
  return nullptr;
}

}  // namespace rubicon::contract
