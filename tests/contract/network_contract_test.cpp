#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>

#include "config/yaml.h"
#include "contract/peers.h"
#include "island/network_types.h"
#include "model/type_names.h"
#include "network-template/template_network.h"
#include "support/fake_host.h"
#include "transport/local_transports.h"

namespace rubicon {
namespace {

using namespace std::chrono_literals;
using model::Acknowledge;

std::vector<network::NetworkType> all_types() {
  const auto built_in = island::network_types();
  std::vector<network::NetworkType> types(built_in.begin(), built_in.end());
  types.push_back(networks::template_network::kType);
  return types;
}

/// What every type of network promises (docs/adding-a-network.md), asked of its own sample configuration.
class NetworkContract : public ::testing::TestWithParam<network::NetworkType> {
 protected:
  NetworkContract() {
    auto parsed = config::parse_yaml(GetParam().sample_config, "sample.yaml");
    EXPECT_TRUE(parsed) << parsed.error().text;
    if (!parsed || parsed->entries.size() != 1) return;
    id_ = parsed->entries[0].first;
    options_ = parsed->entries[0].second;
    std::erase_if(options_.entries, [](const auto& entry) {
      return entry.first == "type" || entry.first == "silence" || entry.first == "rate" || entry.first == "devices";
    });
    // Recordings named in samples stand beside the examples.
    host_.lines = &lines_;
    directory_ = std::string(RUBICON_SOURCE_DIR) + "/examples";
    peer_ = contract::peer_of(GetParam().name, options_, types_, host_);
  }

  Result<std::unique_ptr<network::Network>> make() {
    ConfigReader reader(options_, "networks." + id_, errors_);
    auto made = GetParam().make({id_, IslandId{1}, reader, types_, directory_}, host_);
    reader.finish();
    return made;
  }
  /// Open, and some virtual time later.
  std::unique_ptr<network::Network> running() {
    auto made = make();
    EXPECT_TRUE(made) << errors_.text();
    if (!made) return nullptr;
    if (auto opened = (*made)->open(); !opened) host_.failed(opened.error());
    host_.time.run_for(5s);
    return std::move(*made);
  }
  std::set<std::string> devices() const {
    std::set<std::string> joined;
    for (const auto& [device, join] : host_.all<model::Join>()) joined.insert(device);
    return joined;
  }
  std::vector<model::PointId> points_of(const std::string& device) const {
    std::vector<model::PointId> points;
    for (const auto& [joined, join] : host_.all<model::Join>()) {
      for (const auto& capability : join.capabilities) {
        if (joined == device) points.push_back(capability.point);
      }
    }
    return points;
  }
  void expect_an_answer(network::Network& network, const std::string& device, const model::Body& body,
                        std::uint64_t request);
  void demand_everything(network::Network& network);

  std::string id_, directory_;
  ConfigNode options_;
  ConfigErrors errors_;
  TypeCatalogue types_;
  transport::LocalTransports disk_;
  support::FakeHost host_;
  contract::DiskAndMemory lines_{disk_, host_.files};
  std::unique_ptr<contract::Peer> peer_;
};

void NetworkContract::expect_an_answer(network::Network& network, const std::string& device, const model::Body& body,
                                       std::uint64_t request) {
  Message message;
  message.origin = IslandId{1};
  message.number = request;
  message.source.island = IslandId{1};
  message.destination = {IslandId{1}, id_, device};
  message.body = body;
  const auto sent = network.send(message);
  if (!sent) {
    EXPECT_FALSE(sent.error().text.empty()) << "an error without a reason";
    return;
  }
  host_.time.run_for(30s);
  const auto answers = host_.all<Acknowledge>();
  EXPECT_TRUE(std::any_of(answers.begin(), answers.end(), [&](const auto& a) { return a.second.request == request; }))
      << to_string(message.kind()) << " to device '" << device << "' was met with silence";
}

void NetworkContract::demand_everything(network::Network& network) {
  for (const auto& device : devices()) {
    model::Sample sample{1, {}, 200ms};
    for (const auto& point : points_of(device)) {
      if (point.kind == Kind::kSensor) sample.points.push_back(point);
    }
    Message message;
    message.destination = {IslandId{1}, id_, device};
    message.body = std::move(sample);
    static_cast<void>(network.send(message));
  }
}

TEST_P(NetworkContract, TheSampleIsAMapOfOneNetworkOfThisType) {
  const auto parsed = config::parse_yaml(GetParam().sample_config, "sample.yaml");
  ASSERT_TRUE(parsed) << parsed.error().text;
  ASSERT_EQ(parsed->entries.size(), 1u);
  const auto* type = parsed->entries[0].second.find("type");
  ASSERT_NE(type, nullptr);
  EXPECT_EQ(type->text, GetParam().name);
  EXPECT_FALSE(GetParam().summary.empty());
}

TEST_P(NetworkContract, MakesTheSampleWithoutAWord) {
  const auto made = make();
  EXPECT_TRUE(made);
  EXPECT_TRUE(errors_.empty()) << errors_.text();
  host_.time.run_for(30s);
  EXPECT_TRUE(host_.delivered.empty());
  EXPECT_TRUE(host_.failures.empty());
}

TEST_P(NetworkContract, UnknownOptionsAreRefusedWithTheirPlace) {
  ConfigNode strange;
  strange.kind = ConfigNode::Kind::kScalar;
  strange.place = {"island.yaml", 12, 5};
  options_.entries.emplace_back("no-such-option", strange);
  static_cast<void>(make());
  EXPECT_NE(errors_.text().find("island.yaml:12:5"), std::string::npos) << errors_.text();
  EXPECT_NE(errors_.text().find("no-such-option"), std::string::npos) << errors_.text();
}

TEST_P(NetworkContract, EveryKindOfMessageIsAnswered) {
  auto network = running();
  ASSERT_NE(network, nullptr);
  auto known = devices();
  known.insert({"no such device", ""});
  const model::PointId nowhere{Kind::kSensor, TypeId{0xfff0}, "1"};
  std::uint64_t request = 100;
  for (const auto& device : known) {
    auto points = points_of(device);
    points.push_back(nowhere);
    for (const auto& point : points) {
      const auto* type = types_.find(point.type);
      const bool is_number = type == nullptr || type->data != model::DataType::kBoolean;
      const Value value = is_number ? Value(1.0) : Value(true);
      for (const model::Body& body :
           {model::Body(model::Actuate{request, point, value}), model::Body(model::Sample{request + 1, {point}, 1s}),
            model::Body(model::SetProperty{request + 2, point, value})}) {
        expect_an_answer(*network, device, body, request++);
      }
    }
    for (const model::Body& body :
         {model::Body(model::Join{}), model::Body(model::KeepAlive{}), model::Body(model::Leave{}),
          model::Body(model::Updates{}), model::Body(Acknowledge{}), model::Body(model::State{}),
          model::Body(model::Opaque{"note", {1, 2, 3}}), model::Body(model::Probe{}),
          model::Body(model::Unreachable{"no answer"})}) {
      expect_an_answer(*network, device, body, request++);
    }
  }
}

TEST_P(NetworkContract, OpeningTwiceIsSafe) {
  auto network = running();
  ASSERT_NE(network, nullptr);
  static_cast<void>(network->open());
  host_.time.run_for(10s);
  demand_everything(*network);
  static_cast<void>(network->open());
  host_.time.run_for(30s);
  SUCCEED();
}

TEST_P(NetworkContract, AfterItsEndItSaysNothing) {
  for (const Duration lived : {Duration(0s), Duration(1ms), Duration(1s), Duration(65s)}) {
    auto network = running();
    ASSERT_NE(network, nullptr);
    demand_everything(*network);
    host_.time.run_for(lived);
    network.reset();
    const auto said = host_.delivered.size(), failed = host_.failures.size();
    host_.time.run_for(10min);
    EXPECT_EQ(host_.delivered.size(), said);
    EXPECT_EQ(host_.failures.size(), failed);
  }
}

TEST_P(NetworkContract, DevicesJoinBeforeTheySpeakAndReportOnlyWhatTheyJoinedWith) {
  auto network = running();
  ASSERT_NE(network, nullptr);
  demand_everything(*network);
  host_.time.run_for(5min);
  std::map<std::string, std::set<model::PointId>> joined;
  std::size_t readings = 0;
  for (const auto& message : host_.delivered) {
    const auto& device = message.source.device;
    if (const auto* join = std::get_if<model::Join>(&message.body)) {
      joined[device].clear();
      for (const auto& capability : join->capabilities) joined[device].insert(capability.point);
    }
    EXPECT_TRUE(message.kind() != MessageKind::kKeepAlive || joined.contains(device)) << device;
    const auto* updates = std::get_if<model::Updates>(&message.body);
    if (updates == nullptr) continue;
    EXPECT_TRUE(joined.contains(device)) << device << " reports before it joined";
    readings += updates->readings.size();
    for (const auto& reading : updates->readings) {
      EXPECT_TRUE(joined[device].contains(reading.point)) << device << " reports a point it did not join with";
    }
  }
  EXPECT_GT(joined.size(), 0u);
  EXPECT_GT(readings, 0u);
}

/// Discovery rules do not apply to a device that was not heard, unless its type discovers: the options must name it.
TEST_P(NetworkContract, ADeviceThatWasNotHeardIsNamedByTheOptionsUnlessItsTypeDiscovers) {
  auto network = running();
  ASSERT_NE(network, nullptr);
  model::Join known;  // as another version of the network announced it
  known.capabilities.resize(1);
  known.capabilities[0].point = {Kind::kSensor, types_.find("temperature")->id, "1"};
  auto probed = devices();
  probed.insert("4242");
  for (const auto& device : probed) {
    Message probe;
    probe.source.island = IslandId{1};
    probe.destination = {IslandId{1}, id_, device};
    probe.body = model::Probe{known};
    static_cast<void>(network->send(probe));
  }
  host_.time.run_for(30s);
  const auto listed = network->listed().value_or(std::vector<network::ListedDevice>());
  const auto is_listed = [&](const std::string& address) {
    return std::any_of(listed.begin(), listed.end(), [&](const auto& one) { return one.address == address; });
  };
  for (const auto& [device, join] : host_.all<model::Join>())
    EXPECT_TRUE(join.heard || GetParam().discovers || is_listed(device)) << device;
}

TEST_P(NetworkContract, ValuesFitTheirTypes) {
  auto network = running();
  ASSERT_NE(network, nullptr);
  demand_everything(*network);
  host_.time.run_for(5min);
  std::map<std::string, std::map<model::PointId, std::unique_ptr<model::OpenType>>> open;
  for (const auto& [device, join] : host_.all<model::Join>()) {
    for (const auto& one : join.capabilities) {
      if (types_.find(one.point.type) == nullptr && one.data)
        open[device][one.point] = std::make_unique<model::OpenType>(one);
    }
  }
  for (const auto& [device, updates] : host_.all<model::Updates>()) {
    for (const auto& reading : updates.readings) {
      if (std::holds_alternative<std::monostate>(reading.value)) continue;
      const auto own = open[device].find(reading.point);
      const auto* type = own == open[device].end() ? types_.find(reading.point.type) : &own->second->type();
      ASSERT_NE(type, nullptr) << device;
      const auto fits = TypeCatalogue::check(*type, reading.value);
      EXPECT_TRUE(fits) << device << ": " << fits.error().text;
    }
  }
}

TEST_P(NetworkContract, ALineThatWorksIsAnnounced) {
  auto network = running();
  ASSERT_NE(network, nullptr);
  const auto states = host_.all<model::State>();
  const bool up = std::any_of(states.begin(), states.end(),
                              [](const auto& s) { return s.first.empty() && s.second.line == model::LineState::kUp; });
  EXPECT_TRUE(up || !host_.failures.empty());
}

TEST_P(NetworkContract, ItsLastWordsAreBriefAndThenItSaysNothing) {
  for (const Duration lived : {Duration(0s), Duration(10s)}) {
    auto network = running();
    ASSERT_NE(network, nullptr);
    demand_everything(*network);
    host_.time.run_for(lived);
    int closed = 0;
    const bool speaks = network->close([&closed] { ++closed; });
    EXPECT_EQ(closed, 0) << "never before close() returns";
    host_.time.run_for(network::kClosingTime);
    EXPECT_EQ(closed, speaks ? 1 : 0);
    network.reset();
    host_.time.run_for(1min);
    EXPECT_EQ(closed, speaks ? 1 : 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Every, NetworkContract, ::testing::ValuesIn(all_types()),
                         [](const auto& type) { return std::string(type.param.name); });

}  // namespace
}  // namespace rubicon
