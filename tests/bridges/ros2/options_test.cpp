#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "bridges/ros2/ros2_bridge.h"
#include "support/config_text.h"

namespace rubicon::bridges::ros2 {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

struct Read {
  Options options;
  std::string errors;
};

Read read(const std::string& text, const std::map<std::string, std::string>& environment = {}) {
  const auto config = support::config_of(nlohmann::ordered_json(nlohmann::json::parse(text)));
  base::ConfigErrors errors;
  ConfigReader reader(config, "bridges.robots", errors);
  auto options = read_options(reader, [&](const std::string& name) {
    const auto found = environment.find(name);
    return found == environment.end() ? std::string() : found->second;
  });
  reader.finish();
  return {std::move(options), errors.text()};
}

Reach reach(const std::map<std::string, std::string>& environment, const std::string& text = "{}") {
  return read(text, environment).options.reach;
}

TEST(Ros2Options, MeetRobotsOfThisHostOnlyUnlessSomebodySaysMore) {
  EXPECT_THAT(reach({}).interfaces, ElementsAre("lo"));
  EXPECT_THAT(reach({{"ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"}}).interfaces, IsEmpty());
  EXPECT_THAT(reach({{"ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"}}).interfaces, ElementsAre("lo"));
  EXPECT_THAT(reach({{"ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"}, {"ROS_LOCALHOST_ONLY", "1"}}).interfaces,
              ElementsAre("lo"));
  EXPECT_THAT(reach({{"ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"}}, R"({"interfaces": "eth0"})").interfaces,
              ElementsAre("eth0"));
  EXPECT_THAT(reach({}, R"({"interfaces": "any"})").interfaces, IsEmpty());
  EXPECT_FALSE(reach({{"ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"}}).discovers);
}

TEST(Ros2Options, TakeTheDomainAndThePeersOfTheEnvironment) {
  EXPECT_EQ(reach({}).domain, 0U);
  EXPECT_EQ(reach({{"ROS_DOMAIN_ID", "42"}}).domain, 42U);
  EXPECT_EQ(reach({{"ROS_DOMAIN_ID", "42"}}, R"({"domain": 7})").domain, 7U);
  EXPECT_THAT(reach({{"ROS_STATIC_PEERS", "10.0.0.7; robot.lan"}}).peers, ElementsAre("10.0.0.7", "robot.lan"));
  EXPECT_EQ(reach({{"CYCLONEDDS_URI", "file:///etc/cyclone.xml"}}).cyclone, "file:///etc/cyclone.xml");
}

TEST(Ros2Options, NameWhatIsWrong) {
  EXPECT_THAT(read(R"({"domain": 233})").errors, HasSubstr("bridges.robots.domain"));
  EXPECT_THAT(read("{}", {{"ROS_DOMAIN_ID", "233"}}).errors, HasSubstr("ROS_DOMAIN_ID"));
  EXPECT_THAT(read("{}", {{"ROS_AUTOMATIC_DISCOVERY_RANGE", "FAR"}}).errors, HasSubstr("SUBNET"));
  EXPECT_THAT(read(R"({"namespace": "my home"})").errors, HasSubstr("namespace"));
  EXPECT_THAT(read(R"({"distribution": "foxy"})").errors, HasSubstr("humble"));
  EXPECT_THAT(read(R"({"diagnostics": "1ms"})").errors, HasSubstr("diagnostics"));
  EXPECT_THAT(read(R"({"peers": ["a b"]})").errors, HasSubstr("peers"));
  EXPECT_THAT(read(R"({"import": [{"topic": "battery"}]})").errors, HasSubstr("/battery_state"));
  EXPECT_THAT(read(R"({"import": [{"topic": "/b", "as": "robot.batery-1"}]})").errors, HasSubstr("battery"));
  EXPECT_THAT(read(R"({"import": [{"topic": "/b", "as": "ro bot"}]})").errors, HasSubstr("as"));
  EXPECT_THAT(read(R"({"import": [{"topic": "/b", "as": "robot", "part": "x"}]})").errors, HasSubstr("TYPE-INSTANCE"));
  EXPECT_THAT(read(R"({"domian": 7})").errors, HasSubstr("domain"));
  EXPECT_EQ(read(R"({"import": [{"topic": "/b", "as": "robot.x-1", "type": "length", "part": "x"}]})").errors, "");
  EXPECT_EQ(read(R"({"domain": 232, "diagnostics": "never", "import": "auto"})").errors, "");
}

/// DDSI-RTPS 2.5, 9.6.2.3: ports are 7400 + 250 * domain + 10 + 2 * process, and one more.
TEST(Ros2Options, ShowTheDomainOfRosWithPortsThatThereAre) {
  const auto low = domain_xml(reach({}));
  EXPECT_THAT(low, HasSubstr("<ExternalDomainId>0</ExternalDomainId>"));
  EXPECT_THAT(low, HasSubstr("<NetworkInterface name=\"lo\" multicast=\"true\"/>"));
  EXPECT_THAT(low, HasSubstr("<Peer address=\"127.0.0.1:7410\"/>"));
  EXPECT_THAT(domain_xml(reach({}, R"({"domain": 232})")), HasSubstr("<MaxAutoParticipantIndex>62<"));
  const auto off = domain_xml(reach({{"ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"}}));
  EXPECT_THAT(off, HasSubstr("<AllowMulticast>false<"));
  EXPECT_THAT(off, Not(HasSubstr("<Peer ")));
  EXPECT_THAT(domain_xml(reach({{"CYCLONEDDS_URI", "<General/>"}})), ::testing::EndsWith(",<General/>"));
}

}  // namespace
}  // namespace rubicon::bridges::ros2
