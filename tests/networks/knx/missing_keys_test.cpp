#include "networks/knx/secure_access.h"

#include "networks/knx/secure_bench.h"
#include "support/knx_project.h"

namespace rubicon::networks::knx {
namespace {

using model::LineState;
using model::Outcome;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

/// A plain interface; the configuration says that four groups are secured, one of which only the bus reads.
constexpr std::string_view kSecuredGroups = R"({"host": "10.0.0.9", "telegrams-per-second": 0,
  "secured-groups": ["1/0/1", "1/0/2", "1/2/7", "6/0/1"], "groups": {
  "1/0/1": {"dpt": "1.001", "kind": "actuator", "state": "1/0/2"},
  "1/0/3": {"dpt": "1.001", "kind": "actuator"},
  "1/2/7": {"dpt": "9.001", "read": "init"},
  "1/2/8": {"dpt": "9.001"}},
  "expose": {"6/0/1": {"tuple": "here.now", "dpt": "9.001"}}})";

class KeylessGroups : public SecureKnx {
 protected:
  /// How many telegrams for a group reached the bus.
  int sent_to(std::string_view address) const {
    int count = 0;
    for (const auto& one : server.heard()) count += one.destination == group(address) ? 1 : 0;
    return count;
  }
  void switch_on(const std::string& device) {
    ASSERT_TRUE(send(model::Actuate{7, point(Kind::kActuator, "switch"), true}, device));
    host.time.run_for(10s);
  }
  void subscribe(const std::string& device, std::string_view type) {
    ASSERT_TRUE(send(model::Sample{9, {point(Kind::kSensor, type)}, 1s}, device));
    host.time.run_for(10s);
  }
};

TEST_F(KeylessGroups, GetNoPlainTelegram) {
  start(kSecuredGroups);
  subscribe("1/2/7", "temperature");
  switch_on("1/0/1");
  EXPECT_THAT(outcomes(), Contains(Outcome::kRefused));
  EXPECT_EQ(sent_to("1/0/1") + sent_to("1/0/2") + sent_to("1/2/7"), 0) << "neither a command nor a read";
  switch_on("1/0/3");
  EXPECT_EQ(sent_to("1/0/3"), 1) << "not secured";
}

TEST_F(KeylessGroups, TakeNoPlainTelegram) {
  start(kSecuredGroups);
  server.inject(0x111e, group("1/2/7"), 0x80, {0x0c, 0x33});
  server.inject(0x111e, group("1/0/2"), 0x80, {1}, true);
  server.inject(0x111e, group("1/2/8"), 0x80, {0x0c, 0x33});
  host.time.run_for(1s);
  EXPECT_THAT(values_of("1/2/7"), IsEmpty());
  EXPECT_THAT(values_of("1/0/1"), IsEmpty());
  EXPECT_THAT(values_of("1/2/8"), ElementsAre("21.5"));
  EXPECT_EQ(count("data-secure-plain-dropped"), 2U);
}

TEST_F(KeylessGroups, AreNotAnsweredOrWrittenFromATuple) {
  start(kSecuredGroups);
  host.followed.at("here.now")("22.5");
  server.inject_read(0x111e, group("6/0/1"));
  host.time.run_for(10s);
  EXPECT_EQ(sent_to("6/0/1"), 0);
  EXPECT_TRUE(host.words.contains("6/0/1: here.now: 6/0/1 is secured, and its key is not known"));
  EXPECT_GE(count("data-secure-refused"), 2U);
}

TEST_F(KeylessGroups, AreNamedWithTheRemedyWhileTheLineIsUp) {
  start(kSecuredGroups);
  EXPECT_EQ(last_state().line, LineState::kUp);
  EXPECT_EQ(
      last_state().reason,
      "there are no keys for the secured groups 1/0/1, 1/0/2, 1/2/7, 6/0/1: nothing is sent to them or taken from "
      "them; export a keyring from ETS and configure `keyring`");
  const auto missing = network->missing();
  ASSERT_THAT(missing, SizeIs(1));
  EXPECT_EQ(missing[0].text, last_state().reason);
}

TEST_F(KeylessGroups, AreNotReadTwiceInVain) {
  start(kSecuredGroups);
  host.time.run_for(1min);
  EXPECT_EQ(count("unanswered-reads"), 1U);
  EXPECT_TRUE(host.words.contains("1/2/7: cannot be read: 1/2/7 is secured, and its key is not known"));
  EXPECT_FALSE(host.words.contains("no device on the bus answers"));
}

TEST_F(KeylessGroups, ComeFromAProject) {
  host.files.put("house.knxproj", support::small_house(23).file());
  start(R"({"host": "10.0.0.9", "import": "house.knxproj"})");
  EXPECT_THAT(last_state().reason, HasSubstr("no key for the secured group 2/0/2: "));
  server.inject(0x1105, group("2/0/2"), 0x80, {0x0c, 0x33});
  server.inject(0x1105, group("2/0/1"), 0x80, {0x0c, 0x33});
  host.time.run_for(1s);
  EXPECT_THAT(values_of("2/0/2"), IsEmpty());
  EXPECT_THAT(values_of("2/0/1"), SizeIs(1));
  EXPECT_EQ(network->missing().at(0).option, "import");
}

TEST_F(KeylessGroups, OfTheProjectStaySecuredWhereTheConfigurationDescribesThemAnew) {
  host.files.put("house.knxproj", support::small_house(23).file());
  start(R"({"host": "10.0.0.9", "import": "house.knxproj", "groups": {"2/0/2": "9.001"}})");
  server.inject(0x1105, group("2/0/2"), 0x80, {0x0c, 0x33});
  host.time.run_for(1s);
  EXPECT_THAT(values_of("2/0/2"), IsEmpty());
}

TEST_F(KeylessGroups, AreThoseThatTheKeyringLacks) {
  std::string options(kSecureHouse);
  options.insert(1, R"("secured-groups": ["1/2/7", "1/2/8"], )");
  start(options);
  EXPECT_EQ(last_state().line, LineState::kUp);
  EXPECT_THAT(last_state().reason,
              AllOf(HasSubstr("no key for the secured group 1/2/8: "), HasSubstr("export the keyring")));
  EXPECT_EQ(network->missing().back().option, "keyring");
  EXPECT_EQ(network->missing().back().text, last_state().reason);
  secure_server->inject(0x111e, group("1/2/8"), 0x80, {0x0c, 0x33});
  secure_server->inject_cemi(from_device(group("1/2/7"), {0x0c, 0x33}));
  host.time.run_for(1s);
  EXPECT_THAT(values_of("1/2/8"), IsEmpty());
  EXPECT_THAT(values_of("1/2/7"), ElementsAre("21.5"));
}

TEST_F(KeylessGroups, AnotherListOfSecuredGroupsOpensTheLineAgain) {
  start(kSecuredGroups);
  std::string other(kSecuredGroups);
  other.replace(other.find("\"1/0/1\", "), 9, "");
  EXPECT_EQ(change(other).error().code, ErrorCode::kUnsupported);
  EXPECT_TRUE(change(kSecuredGroups));
}

TEST_F(KeylessGroups, WrongAddressesAreErrors) {
  const ConfigNode node =
      support::config_of(std::string_view(R"({"host": "10.0.0.9", "secured-groups": ["1/2/7", "1/2/300"]})"));
  ConfigReader reader(node, "networks.knx", errors);
  EXPECT_FALSE(kType.make({"knx", IslandId{1}, reader, types, {}}, host));
  EXPECT_THAT(errors.text(), HasSubstr("secured-groups"));
}

class EveryPolicy : public KeylessGroups, public testing::WithParamInterface<const char*> {};

TEST_P(EveryPolicy, KeepsGroupsWithoutAKeySilent) {
  start(std::string(R"({"via": "tunnel-tcp", "host": ")") +
        (GetParam() == std::string("off") ? "10.0.0.9" : "10.0.0.10") +
        R"(", "keyring": "house.knxkeys", "keyring-password-file": "house.password", "telegrams-per-second": 0,
        "secured-groups": ["1/0/1"], "groups": {"1/0/1": {"dpt": "1.001", "kind": "actuator"}}, "secure": ")" +
        GetParam() + "\"}");
  EXPECT_EQ(last_state().line, LineState::kUp);
  EXPECT_THAT(network->missing().back().text, HasSubstr("no key for the secured group 1/0/1"));
  EXPECT_TRUE(send(model::Actuate{7, point(Kind::kActuator, "switch"), true}, "1/0/1"));
  host.time.run_for(10s);
  EXPECT_THAT(outcomes(), ElementsAre(Outcome::kRefused));
  for (const auto* one : {&server, secure_server.get()})
    for (const auto& heard : one->heard()) EXPECT_NE(heard.destination, group("1/0/1"));
}

INSTANTIATE_TEST_SUITE_P(Policies, EveryPolicy, testing::Values("require", "allow", "off"));

TEST(MissingKeys, LongListsAreCut) {
  std::vector<wire::GroupAddress> groups;
  for (std::uint16_t i = 1; i <= 9; ++i) groups.push_back(wire::GroupAddress(i));
  EXPECT_THAT(explain_missing_keys(groups, {}), HasSubstr("groups 0/0/1, 0/0/2, 0/0/3, 0/0/4 and 5 more: "));
  EXPECT_EQ(explain_missing_keys({}, {}), "");
}

}  // namespace
}  // namespace rubicon::networks::knx
