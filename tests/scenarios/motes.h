#pragma once

#include <gmock/gmock.h>
#include <stdlib.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <set>
#include <utility>
#include <vector>

#include "apps/simulators/motes/world.h"
#include "island/network_types.h"
#include "scenarios/ecology.h"
#include "state/state_store.h"
#include "support/memory/memory_sinks.h"

namespace rubicon::scenarios {

/// Islands with networks of motes, simulated motes and sinks on the other side of their lines, and a component that
/// sees everything and wants nothing.
class Motes : public Ecology {
 protected:
  static constexpr const char* kMotesHost = "10.0.0.9";
  static constexpr std::uint32_t kWatcher = 70000, kRobot = 70001;

  Motes() {
    transports.join(net, "10.0.0.1");
    sees_ = watcher().subscribe({std::nullopt, "**"}, {.passive = true}, [](const Event&) {});
  }
  ~Motes() override {
    islands.clear();
    components.clear();
    for (const auto& folder : folders_) std::filesystem::remove_all(folder);
  }

  static motes_simulator::MoteOptions em1000(bool obey = false) {
    motes_simulator::MoteOptions options;
    options.board = motes_simulator::parse_build("EM1000").value();
    options.obey = obey;
    return options;
  }
  /// The sinks are reachable at ports 19202, 19203, ...; motes are switched on after the first connection.
  void begin_world() {
    setup.wait_for_computer = true;
    world = std::make_unique<motes_simulator::World>(
        setup, scheduler, std::vector<motes_simulator::Step>{},
        [this](const motes_simulator::Event& event) { happened.push_back(event); });
    for (std::uint16_t sink = 1; sink <= world->sinks(); ++sink) {
      const auto port = static_cast<std::uint16_t>(19201 + sink);
      ASSERT_TRUE(world->open(sink, motes_simulator::on_memory(net.tcp, {kMotesHost, port})));
      world->sink(sink).watch([this, sink](bool written, ByteView packet) {
        auto& packets = written ? to_sink[sink] : from_sink[sink];
        packets.emplace_back(packet.begin(), packet.end());
      });
    }
  }
  /// One sink with so many motes, from address 2 on.
  void begin_world(std::uint16_t motes, const motes_simulator::MoteOptions& like) {
    setup.add_motes(1, 2, motes, like);
    begin_world();
  }
  static std::string network(const std::string& id, std::uint16_t sink, const std::string& more = "") {
    return id + ": {type: wsn, board: EM1000, silence: 60s, share: no, source: \"network@" + kMotesHost + ":" +
           std::to_string(19201 + sink) + "\"" + (more.empty() ? "" : ", " + more) + "}";
  }
  island::Island& start(std::uint32_t id, const std::string& networks, const std::string& state = {}) {
    const auto text = "island: {id: " + std::to_string(id) + ", name: test}\nnetworks:\n  " + networks + "\n";
    base::ConfigErrors errors;
    const auto tree = config::parse_yaml(text, "island.yaml");
    EXPECT_TRUE(tree) << text;
    auto config = island::read_island_config(tree.value(), island::network_types(), errors);
    std::unique_ptr<state::StateStore> store;
    if (!state.empty()) store = std::move(*state::StateStore::open(state, OwnerId(id), {}));
    auto made = island::Island::make(std::move(config), scheduler, transports, log, ecology, errors, std::move(store));
    EXPECT_TRUE(made.has_value()) << errors.text();
    auto& island = *(islands[id] = std::move(*made));
    island.start();
    scheduler.run_ready();
    return island;
  }
  std::string state_file() {
    folders_.push_back(testing::TempDir() + "motes-simulator-XXXXXX");
    EXPECT_NE(::mkdtemp(folders_.back().data()), nullptr);
    return folders_.back() + "/island.state";
  }

  TupleSpace& watcher() { return component(kWatcher); }
  std::string seen(std::uint32_t island, const std::string& key) { return value(watcher(), island, key); }
  nlohmann::json seen_json(std::uint32_t island, const std::string& key) { return json(watcher(), island, key); }
  /// `reachable`, `unreachable`, `unknown`, or null when the island does not list it.
  nlohmann::json status(std::uint32_t island, const std::string& device) {
    const auto found = seen_json(island, "proxy." + device + ".status");
    return found.is_object() ? found.value("status", nlohmann::json()) : nlohmann::json();
  }
  bool reachable(std::uint32_t island, const std::string& device) { return status(island, device) == "reachable"; }
  std::uint64_t counter(std::uint32_t island, const std::string& network, const std::string& name) {
    const auto text = seen(island, "proxy." + network + ".property." + name + ".value");
    return text.empty() || text.front() == '(' ? ~std::uint64_t{0} : std::stoull(text);
  }

  /// A subscriber to this sensor, `wsn-1.2.sensor.light-1`.
  [[nodiscard]] Handle want(std::uint32_t island, const std::string& sensor, Flow flow = {},
                            std::uint32_t who = kRobot) {
    auto subscription =
        component(who).subscribe({OwnerId(island), "proxy." + sensor + ".value"}, flow, [](const Event&) {});
    scheduler.run_ready();
    return subscription;
  }
  /// Values published of one tuple from now on, in order.
  struct Heard {
    std::vector<std::string> values;
    Handle ears;
  };
  std::unique_ptr<Heard> hear(std::uint32_t island, const std::string& point) {
    auto heard = std::make_unique<Heard>();
    heard->ears = watcher().subscribe({OwnerId(island), "proxy." + point + ".value"}, {.passive = true},
                                      [into = heard.get()](const Event& event) {
                                        const std::string value(event.tuple.value);
                                        if (event.kind == EventKind::kSet && !value.empty())
                                          into->values.push_back(value);
                                      });
    scheduler.run_ready();
    return heard;
  }
  /// A command, to what it is applied or refused with.
  tuples::Reply command(std::uint32_t island, const std::string& point, const std::string& value,
                        Duration time_to_live = 0s) {
    tuples::Reply answer;
    component(kRobot).set_remote(OwnerId(island), "proxy." + point + ".command", value, time_to_live,
                                 [&](const tuples::Reply& reply) { answer = reply; });
    scheduler.run_for(10ms);
    return answer;
  }
  nlohmann::json command_state(std::uint32_t island, const std::string& point) {
    const auto found = seen_json(island, "proxy." + point + ".status");
    return found.is_object() && found.contains("command") ? found["command"].value("state", nlohmann::json())
                                                          : nlohmann::json();
  }

  std::size_t events(std::string_view what, std::uint16_t mote = 0, std::uint16_t sink = 0) const {
    return static_cast<std::size_t>(std::count_if(happened.begin(), happened.end(), [&](const auto& event) {
      return event.what == what && (mote == 0 || event.mote == mote) && (sink == 0 || event.sink == sink);
    }));
  }

  transport::MemoryNet net{scheduler};
  motes_simulator::WorldOptions setup;
  std::vector<motes_simulator::Event> happened;
  std::map<std::uint16_t, std::vector<Bytes>> to_sink, from_sink;  ///< packets, by sink
  std::unique_ptr<motes_simulator::World> world;

 private:
  Handle sees_;
  std::vector<std::string> folders_;
};

/// The radio messages among packets, as views of them.
inline std::vector<motes::NetMessage> radio_messages(const std::vector<Bytes>& packets) {
  std::vector<motes::NetMessage> messages;
  for (const auto& bytes : packets) {
    const auto packet = motes::decode_packet(bytes);
    if (!packet || !packet->is(motes::AmType::kNetMessage)) continue;
    if (const auto message = motes::decode_net(packet->payload)) messages.push_back(*message);
  }
  return messages;
}

}  // namespace rubicon::scenarios
