#pragma once

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "apps/simulators/motes/world.h"
#include "motes/framing.h"
#include "motes/mote_records.h"
#include "networks/wsn/wsn_network.h"
#include "support/config_text.h"
#include "support/fake_host.h"
#include "support/memory/memory_sinks.h"

namespace rubicon::networks::wsn {

using namespace std::chrono_literals;

inline motes_simulator::MoteOptions em1000() {
  motes_simulator::MoteOptions options;
  options.board = motes_simulator::parse_build("EM1000").value();
  return options;
}

/// A network of motes on the computer's side, and simulated motes and sinks on the other, in virtual time.
class MoteNetwork : public ::testing::Test {
 protected:
  static constexpr std::uint16_t kIsland = 42;

  MoteNetwork() { options["source"] = "network@127.0.0.1:19202"; }

  /// Motes from address 2 on at one sink. Before open().
  void world(std::uint16_t count, motes_simulator::MoteOptions like = {}) {
    setup.add_motes(1, 2, count, like);
    setup.wait_for_computer = true;
    make_world();
  }
  void make_world() {
    motes = std::make_unique<motes_simulator::World>(
        setup, host.time, std::vector<motes_simulator::Step>{},
        [this](const motes_simulator::Event& event) { happened.push_back(event); });
    ASSERT_TRUE(motes->open(1, motes_simulator::on_memory(host.net.tcp, {"127.0.0.1", 19202})));
  }
  Result<std::unique_ptr<network::Network>> make(std::string* errors = nullptr) {
    config_ = support::config_of(options);
    ConfigErrors wrong;
    ConfigReader reader(config_, "networks.wsn-1", wrong);
    auto made = kType.make({"wsn-1", IslandId{kIsland}, reader, types, {}}, host);
    reader.finish();
    if (errors) {
      *errors = wrong.text();
      return made;
    }
    EXPECT_TRUE(wrong.empty()) << wrong.text();
    return made;
  }
  void open() {
    auto made = make();
    ASSERT_TRUE(made);
    network = std::move(*made);
    ASSERT_TRUE(network->open());
  }
  /// So many motes of the EM1000 build, joined.
  void start(std::uint16_t count) {
    world(count, em1000());
    open();
    run(5s);
  }
  /// As the supervisor does it.
  void reopen_when_lost(Duration pause = 200ms) {
    if (host.failures.size() == reopened_) return;
    reopened_ = host.failures.size();
    reopening_ = host.time.after(pause, [this] { std::ignore = network->open(); });
  }
  void run(Duration span) {
    for (const auto end = host.time.now() + span; host.time.now() < end;) {
      host.time.run_for(std::min<Duration>(50ms, end - host.time.now()));
      reopen_when_lost();
    }
  }

  Result<void> send(const std::string& device, model::Body body, Address from = {IslandId{kIsland}, "", ""}) {
    model::Message message;
    message.origin = IslandId{kIsland};
    message.number = ++last_number;
    message.source = std::move(from);
    message.destination = {IslandId{kIsland}, "wsn-1", device};
    message.body = std::move(body);
    return network->send(message);
  }
  Result<void> demand(const std::string& device, const std::vector<std::string>& sensors,
                      std::chrono::milliseconds period = 1s) {
    model::Sample sample{++last_request, {}, period};
    for (const auto& name : sensors) sample.points.push_back({Kind::kSensor, types.find(name)->id, "1"});
    return send(device, std::move(sample));
  }
  Result<void> light_up(const std::string& device, std::int64_t value) {
    return send(device, model::Actuate{++last_request, {Kind::kActuator, types.find("led")->id, "1"}, value, 5s});
  }
  /// Connects another sink instead of the simulated one, which sends this.
  void from_the_sink(std::string_view packet) {
    motes->port(1).pull();
    run(1s);
    listener_ = host.net.tcp.listen({"127.0.0.1", 19202}, [this](auto stream) {
      other_sink_ = std::move(stream);
      return transport::TcpCallbacks{};
    });
    run(2s);
    ASSERT_TRUE(other_sink_);
    ASSERT_TRUE(other_sink_->send(motes::hdlc_packet(base::from_hex(packet).value())));
    run(1s);
  }
  /// That sink sends more.
  void from_the_same_sink(std::string_view packet) {
    ASSERT_TRUE(other_sink_->send(motes::hdlc_packet(base::from_hex(packet).value())));
    run(100ms);
  }

  model::Acknowledge answer(std::uint64_t request) const {
    for (const auto& [device, ack] : host.all<model::Acknowledge>()) {
      if (ack.request == request) return ack;
    }
    return {0, model::Outcome::kBusy, "no answer"};
  }
  std::set<std::string> joined() const {
    std::set<std::string> devices;
    for (const auto& [device, join] : host.all<model::Join>()) devices.insert(device);
    return devices;
  }
  /// Readings of one sensor, `7 light`.
  std::vector<double> readings(const std::string& device, std::string_view type) const {
    std::vector<double> values;
    for (const auto& [from, updates] : host.all<model::Updates>()) {
      for (const auto& reading : updates.readings) {
        if (from != device || reading.point.type != types.find(type)->id) continue;
        const auto* real = std::get_if<double>(&reading.value);
        const auto* whole = std::get_if<std::int64_t>(&reading.value);
        values.push_back(real ? *real : whole ? static_cast<double>(*whole) : -1);
      }
    }
    return values;
  }
  std::uint64_t counter(const std::string& name) {
    host.time.run_for(2s);
    std::uint64_t value = 0;
    for (const auto& [device, state] : host.all<model::State>()) {
      if (const auto found = state.counters.find(name); found != state.counters.end()) value = found->second;
    }
    return value;
  }
  model::LineState line() const {
    const auto states = host.all<model::State>();
    return states.empty() ? model::LineState::kDown : states.back().second.line;
  }
  std::size_t events(std::string_view what) const {
    return static_cast<std::size_t>(
        std::count_if(happened.begin(), happened.end(), [&](const auto& event) { return event.what == what; }));
  }

  TypeCatalogue types;
  support::FakeHost host;
  nlohmann::ordered_json options;
  motes_simulator::WorldOptions setup;
  std::vector<motes_simulator::Event> happened;
  std::unique_ptr<motes_simulator::World> motes;
  std::unique_ptr<network::Network> network;
  std::uint64_t last_number = 1000, last_request = 0;

 private:
  ConfigNode config_;
  std::size_t reopened_ = 0;
  std::unique_ptr<transport::MemoryListener> listener_;
  std::unique_ptr<transport::TcpStream> other_sink_;
  Timer reopening_;
};

}  // namespace rubicon::networks::wsn
