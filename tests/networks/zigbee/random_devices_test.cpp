#include "apps/simulators/zigbee/simulator.h"
#include "apps/simulators/zigbee/world.h"
#include "networks/zigbee/zigbee_house.h"

namespace rubicon::networks::zigbee {
namespace {

using ::testing::SizeIs;

/// A network beside a simulated bridge whose devices have random definitions.
class RandomDevices : public House, public ::testing::WithParamInterface<std::uint64_t> {
 protected:
  static constexpr std::uint32_t kDevices = 60;

  RandomDevices()
      : world_(options(), host.time, Log(host.words, "bridge")),
        line_(world_, at_home(), host.time, host.files, Log(host.words, "bridge")) {
    zigbee_simulator::DefinitionGenerator generator(GetParam());
    for (std::uint32_t i = 0; i < kDevices; ++i)
      EXPECT_TRUE(world_.add(zigbee_simulator::make_model(generator, i), fmt::format("room {}/device", i)));
    EXPECT_TRUE(line_.open());
    host.time.run_for(2s);
    make();
    open();
    host.time.run_for(30s);
  }
  static zigbee_simulator::WorldOptions options() {
    zigbee_simulator::WorldOptions out;
    out.seed = GetParam();
    out.nulls = GetParam() % 2 == 0;
    out.every = 5s;
    return out;
  }
  static transport::MqttOptions at_home() {
    transport::MqttOptions out;
    out.host = "localhost";
    return out;
  }
  static Value some_value(const model::Capability& capability, const Type* type) {
    const auto data = type ? type->data : capability.data.value_or(model::DataType::kReal);
    switch (data) {
      case model::DataType::kBoolean: return true;
      case model::DataType::kInteger:
      case model::DataType::kEnumeration:
        return capability.words.empty() ? Value(std::int64_t{1}) : Value(std::int64_t{capability.words.front().value});
      case model::DataType::kReal: return capability.minimum.value_or(1);
      default: return std::string("x");
    }
  }

  zigbee_simulator::World world_;
  zigbee_simulator::BrokerLine line_;
};

TEST_P(RandomDevices, AllJoinAndAreReadAndEveryCommandIsAnsweredOnce) {
  std::map<std::string, model::Join> joined;
  for (const auto& [address, join] : host.all<model::Join>()) joined[address] = join;
  ASSERT_THAT(joined, SizeIs(kDevices));
  EXPECT_GT(readings(), 0U);
  std::uint64_t request = 1000;
  std::set<std::uint64_t> waiting;
  for (const auto& [address, join] : joined) {
    for (const auto& capability : join.capabilities) {
      const auto* type = types.find(capability.point.type);
      const auto value = some_value(capability, type);
      ++request;
      const auto sent = capability.point.kind == Kind::kProperty
                            ? send(address, model::SetProperty{request, capability.point, value})
                            : send(address, model::Actuate{request, capability.point, value, 10s});
      if (sent) waiting.insert(request);
    }
    host.time.run_for(50ms);
  }
  EXPECT_GT(waiting.size(), kDevices);
  host.time.run_for(31s);
  for (const auto number : waiting) EXPECT_TRUE(answer(number)) << number;
  EXPECT_EQ(counter("unreadable-states"), 0U);
  EXPECT_EQ(counter("unreadable-messages"), 0U);
  EXPECT_EQ(counter("unreadable-lists"), 0U);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomDevices, ::testing::Values(1, 2, 3));

}  // namespace
}  // namespace rubicon::networks::zigbee
