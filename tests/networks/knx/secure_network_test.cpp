#include <nlohmann/json.hpp>

#include "model/findings.h"
#include "networks/knx/secure_bench.h"
#include "networks/knx/tool_requests.h"

namespace rubicon::networks::knx {
namespace {

using model::LineState;
using model::Outcome;
using support::KeyringElement;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

constexpr std::string_view kManualHouse = R"({"host": "10.0.0.9", "telegrams-per-second": 0,
  "group-keys-file": "group.keys", "groups": {"1/2/7": "9.001", "2/0/1": {"dpt": "9.001", "kind": "actuator"}}})";

TEST_F(SecureKnx, AKeyringIsAllThatASecureTunnelNeeds) {
  start(kSecureHouse);
  EXPECT_EQ(last_state().line, LineState::kUp) << last_state().reason;
  EXPECT_EQ(last_state().texts.at("tunnel-address"), "1.1.201");
  EXPECT_EQ(count("secure-sessions"), 1U);
  EXPECT_EQ(count("secure-unverified"), 0U);
  EXPECT_EQ(secure_server->counters.plain_frames, 0U);
}

TEST_F(SecureKnx, KeysAreDerivedApartFromTheLoop) {
  make(kSecureHouse);
  ASSERT_TRUE(network->open());
  EXPECT_TRUE(secure_server->heard().empty());
  host.time.run_for(Duration::zero());
  const auto states = host.all<model::State>();
  ASSERT_FALSE(states.empty());
  EXPECT_EQ(states.front().second.line, LineState::kConnecting);
  EXPECT_THAT(states.front().second.reason, HasSubstr("derives the keys"));
}

TEST_F(SecureKnx, AWrongKeyringPasswordIsSaidAndNothingIsSent) {
  host.files.put("house.password", "another word\n");
  start(kSecureHouse);
  host.time.run_for(10min);
  EXPECT_EQ(last_state().line, LineState::kRefused);
  EXPECT_THAT(last_state().reason,
              AllOf(HasSubstr("house.knxkeys"), HasSubstr("password"), Not(HasSubstr("another word"))));
  EXPECT_EQ(secure_server->sessions()->counters.requests, 0U);
  EXPECT_EQ(secure_server->counters.connects, 0U);
  ASSERT_TRUE(network->open()) << "the supervisor may ask again";
  EXPECT_THAT(host.failures, IsEmpty());
}

TEST_F(SecureKnx, AWrongUserPasswordInTheKeyringIsARefusalOfTheInterface) {
  host.files.put("house.knxkeys", house_keyring("ring word", "five"));
  start(kSecureHouse);
  EXPECT_EQ(last_state().line, LineState::kRefused);
  EXPECT_THAT(last_state().reason, HasSubstr("the interface does not accept user 4"));
  EXPECT_EQ(last_state().finding, model::findings::kUserRefused);
}

TEST_F(SecureKnx, KeysWithoutAKeyring) {
  host.files.put("user.password", "four");
  host.files.put("device.password", "the device");
  start(R"({"via": "tunnel-tcp", "host": "10.0.0.10", "user": 4, "user-password-file": "user.password",
            "device-password-file": "device.password"})");
  EXPECT_EQ(last_state().line, LineState::kUp) << last_state().reason;
  EXPECT_EQ(count("secure-unverified"), 0U);
}

TEST_F(SecureKnx, AnotherDeviceInItsPlaceIsNotTrusted) {
  host.files.put("user.password", "four");
  host.files.put("device.password", "the device that it was");
  start(R"({"via": "tunnel-tcp", "host": "10.0.0.10", "user": 4, "user-password-file": "user.password",
            "device-password-file": "device.password"})");
  EXPECT_EQ(last_state().line, LineState::kRefused);
  EXPECT_THAT(last_state().reason, HasSubstr("not the"));
  EXPECT_EQ(last_state().finding, model::findings::kWrongInterface);
}

TEST_F(SecureKnx, SecuredGroupsAreReadAndWritten) {
  start(kSecureHouse);
  secure_server->inject_cemi(from_device(0x0a07, {0x0c, 0x33}));
  host.time.run_for(1s);
  EXPECT_THAT(values_of("1/2/7"), ElementsAre("21.5"));
  command(21.5);
  EXPECT_THAT(outcomes(), ElementsAre(Outcome::kSent));
  ASSERT_THAT(heard(), SizeIs(1));
  EXPECT_EQ(heard()[0][0] & 0x03, 0x03);
  EXPECT_EQ(heard()[0][1], 0xf1) << "secured";
  EXPECT_EQ(count("data-secure-sent"), 1U);
}

TEST_F(SecureKnx, MonitorsSeeTelegramsOfSecuredGroupsDecrypted) {
  start(kSecureHouse);
  const auto request = base::as_bytes(std::string_view(R"({"id":"m","do":"monitor","seconds":60})"));
  ASSERT_TRUE(send(model::Opaque{std::string(kRequestTag), Bytes(request.begin(), request.end())}, ""));
  secure_server->inject_cemi(from_device(0x0a07, {0x0c, 0x33}));
  host.time.run_for(1s);
  command(22.5);
  std::vector<std::string> seen;
  for (const auto& message : host.delivered) {
    const auto* opaque = std::get_if<model::Opaque>(&message.body);
    if (!opaque || opaque->type != kTelegramTag) continue;
    const auto telegram = nlohmann::json::parse(opaque->bytes);
    seen.push_back(telegram.value("address", "") + " " + telegram.value("value", ""));
    EXPECT_EQ(telegram["secured"], true);
  }
  EXPECT_THAT(seen, ElementsAre("1/2/7 21.5", "2/0/1 22.5"));
}

TEST_F(SecureKnx, NothingPlainIsTakenForASecuredGroup) {
  start(kSecureHouse);
  secure_server->inject(0x111e, 0x0a07, 0x80, {0x0c, 0x33});
  secure_server->inject(0x111e, 0x0a08, 0x80, {0x0c, 0x33});
  host.time.run_for(10s);
  EXPECT_THAT(values_of("1/2/7"), IsEmpty());
  EXPECT_THAT(values_of("1/2/8"), ElementsAre("21.5")) << "not secured";
  EXPECT_EQ(count("data-secure-plain-dropped"), 1U);
}

TEST_F(SecureKnx, ARepeatedTelegramIsDroppedAlsoAfterARestart) {
  start(kSecureHouse);
  const auto telegram = from_device(0x0a07, {0x0c, 0x33});
  secure_server->inject_cemi(telegram);
  secure_server->inject_cemi(telegram);
  host.time.run_for(1min);
  EXPECT_EQ(values_of("1/2/7").size(), 1U);
  network.reset();
  host.delivered.clear();
  start(kSecureHouse);
  secure_server->inject_cemi(telegram);
  host.time.run_for(1s);
  EXPECT_THAT(values_of("1/2/7"), IsEmpty());
}

TEST_F(SecureKnx, SequenceNumbersRiseOverRestartsAndAClockThatIsSetBack) {
  std::uint64_t last = 0;
  for (int i = 0; i < 3; ++i) {
    start(kSecureHouse);
    command(20 + i);
    ASSERT_EQ(heard().size(), static_cast<std::size_t>(i + 1));
    EXPECT_GT(sequence_of(heard().back()), last);
    last = sequence_of(heard().back());
    network.reset();
    host.time.set_wall(host.time.wall_now() - 24h * 365);
  }
}

TEST_F(SecureKnx, WithoutAStateFileSecuredGroupsAreReadOnly) {
  host.forgetful = true;
  start(kSecureHouse);
  EXPECT_EQ(last_state().line, LineState::kUp);
  EXPECT_THAT(last_state().reason, AllOf(HasSubstr("secured groups can only be read: "), HasSubstr("state file")));
  EXPECT_EQ(last_state().finding, model::findings::kGroupsReadOnly);
  EXPECT_TRUE(host.words.contains("secured groups can only be read: "));
  command(21.5);
  EXPECT_THAT(heard(), IsEmpty());
  EXPECT_EQ(count("data-secure-refused"), 1U);
  ASSERT_THAT(outcomes(), SizeIs(1));
  EXPECT_NE(outcomes()[0], Outcome::kSent);
  secure_server->inject_cemi(from_device(0x0a07, {0x0c, 0x33}));
  host.time.run_for(1s);
  EXPECT_THAT(values_of("1/2/7"), ElementsAre("21.5"));
  const auto missing = network->missing();
  ASSERT_THAT(missing, SizeIs(1));
  EXPECT_THAT(missing[0].text, AllOf(HasSubstr("can only be read"), HasSubstr("taken once more")));
  EXPECT_EQ(missing[0].kind, network::Missing::Kind::kWarning);
}

TEST_F(SecureKnx, ChangesOfPointsKeepTheSessionThoseOfKeysDoNot) {
  start(kSecureHouse);
  std::string other(kSecureHouse);
  other.replace(other.find("Garden"), 6, "Terrace");
  ASSERT_TRUE(change(other));
  host.time.run_for(1s);
  EXPECT_EQ(count("secure-sessions"), 1U);
  EXPECT_EQ(last_state().line, LineState::kUp);
  host.files.put("house.password", "another word\n");
  EXPECT_EQ(change(other).error().code, ErrorCode::kUnsupported);
  host.files.put("house.password", "ring word\n");
  host.files.put("house.knxkeys", house_keyring("ring word", "five"));
  EXPECT_EQ(change(other).error().code, ErrorCode::kUnsupported);
}

TEST_F(SecureKnx, TheCheckOfTheConfigurationTriesThePassword) {
  host.files.put("house.password", "another word\n");
  make(kSecureHouse);
  const auto missing = network->missing();
  ASSERT_THAT(missing, SizeIs(1));
  EXPECT_EQ(missing[0].option, "keyring");
  EXPECT_THAT(missing[0].text, HasSubstr("password"));
  EXPECT_EQ(missing[0].kind, network::Missing::Kind::kWrong);
}

TEST_F(SecureKnx, SecureRoutingTakesTheBackboneOfTheKeyring) {
  auto root = support::keyring_root();
  root.add(
      KeyringElement{"Backbone"}.text("MulticastAddress", "224.0.23.77").text("Latency", "1000").key("Key", kGroupKey));
  host.files.put("house.knxkeys", support::write_keyring(root, "ring word"));
  start(R"({"via": "routing", "interface": "127.0.0.1", "keyring": "house.knxkeys",
            "keyring-password-file": "house.password"})");
  host.time.run_for(10s);
  EXPECT_EQ(last_state().line, LineState::kUp);
  EXPECT_THAT(last_state().texts.at("server"), HasSubstr("224.0.23.77"));
  EXPECT_GE(count("secure-notifies-sent"), 1U);
}

TEST_F(SecureKnx, TheCheckOfSecureRoutingWantsAStateFile) {
  host.files.put("backbone.key", "000102030405060708090a0b0c0d0e0f\n");
  make(R"({"via": "routing", "backbone-key-file": "backbone.key"})");
  const auto missing = network->missing();
  ASSERT_THAT(missing, SizeIs(1));
  EXPECT_EQ(missing[0].option, "backbone-key-file");
  EXPECT_THAT(missing[0].text, AllOf(HasSubstr("replayed after a restart"), HasSubstr("state file")));
}

TEST_F(SecureKnx, ARoutingLineWithoutABackboneKeyIsNotPlain) {
  start(R"({"via": "routing", "interface": "127.0.0.1", "keyring": "house.knxkeys",
            "keyring-password-file": "house.password"})");
  EXPECT_EQ(last_state().line, LineState::kRefused);
  EXPECT_THAT(last_state().reason, HasSubstr("no backbone key"));
  EXPECT_EQ(last_state().finding, model::findings::kKeyringNoBackbone);
}

TEST_F(SecureKnx, GroupKeysWithoutAKeyring) {
  host.files.put("group.keys", "1/2/7 " + std::string(kGroupKey) + "\n2/0/1 " + kGroupKey + " sender 1.1.30\n");
  start(kManualHouse);
  EXPECT_EQ(last_state().line, LineState::kUp) << "and plain: these keys are not those of a line";
  EXPECT_EQ(last_state().reason, "");
  const auto telegram = from_device(0x0a07, {0x0c, 0x33});
  server.inject_cemi(telegram);
  server.inject_cemi(telegram);
  server.inject(0x111e, 0x0a07, 0x80, {0x0c, 0x33});
  host.time.run_for(5s);
  EXPECT_THAT(values_of("1/2/7"), ElementsAre("21.5"));
  EXPECT_EQ(count("data-secure-plain-dropped"), 1U);
  command(21.5);
  EXPECT_THAT(outcomes(), ElementsAre(Outcome::kSent));
  ASSERT_FALSE(server.heard().empty());
  EXPECT_EQ(server.heard().back().tpdu[1], 0xf1) << "secured";
}

TEST_F(SecureKnx, AKeyOfTheKeyringGoesBeforeOneOfTheFile) {
  host.files.put("group.keys", "1/2/7 00000000000000000000000000000000\n1/2/8 " + std::string(kGroupKey) + "\n");
  std::string options(kSecureHouse);
  options.insert(1, R"("group-keys-file": "group.keys", )");
  start(options);
  auto keys = device_keys();
  keys.groups[wire::GroupAddress(0x0a08)] = keys.groups[wire::GroupAddress(0x0a07)];
  secure::GroupGuard device(host.time, keys, device_storage(), kDevice, {});
  wire::Telegram telegram;
  telegram.payload = {{0x0c, 0x33}, false};
  for (const auto group : {0x0a07, 0x0a08}) {
    telegram.destination = wire::GroupAddress(static_cast<std::uint16_t>(group));
    secure_server->inject_cemi(device.protect(wire::CemiCode::kDataIndication, telegram, kDevice).value());
  }
  host.time.run_for(1s);
  EXPECT_THAT(values_of("1/2/7"), ElementsAre("21.5"));
  EXPECT_THAT(values_of("1/2/8"), ElementsAre("21.5"));
}

TEST_F(SecureKnx, AnotherGroupKeyOpensTheLineAgain) {
  host.files.put("group.keys", "1/2/7 " + std::string(kGroupKey) + "\n");
  start(kManualHouse);
  EXPECT_TRUE(change(kManualHouse));
  host.files.put("group.keys", "1/2/7 00000000000000000000000000000000\n");
  EXPECT_EQ(change(kManualHouse).error().code, ErrorCode::kUnsupported);
}

TEST_F(SecureKnx, GroupKeysAreInNoLogStateOrTuple) {
  host.files.put("group.keys", "1/2/7 " + std::string(kGroupKey) + "\n");
  start(kManualHouse);
  server.inject_cemi(from_device(0x0a07, {0x0c, 0x33}));
  server.inject_cemi(from_device(0x1001, {0x0c, 0x33}));
  host.time.run_for(1min);
  const auto key = secure::Key::from(base::from_hex(kGroupKey).value()).value();
  const std::string_view raw = base::as_text(key.view());
  const auto clean = [&](std::string_view text) {
    return text.find(kGroupKey) == text.npos && text.find(raw) == text.npos;
  };
  for (const auto& line : host.words.lines) EXPECT_TRUE(clean(line)) << line;
  for (const auto& [name, text] : last_state().texts) EXPECT_TRUE(clean(text)) << name;
  for (const auto& [name, value] : host.memory) EXPECT_TRUE(clean(base::as_text(value))) << name;
  EXPECT_TRUE(clean(last_state().reason));
}

struct WrongOption {
  const char* options;
  const char* error;
};

class WrongSecureOptions : public SecureKnx, public testing::WithParamInterface<WrongOption> {};

TEST_P(WrongSecureOptions, AreNamed) {
  host.files.put("user.password", "four");
  host.files.put("open.password", "four");
  host.files.open_to_all("open.password");
  host.files.put("broken.knxkeys", "<Keyring");
  host.files.put("short.key", "0011");
  const auto text = std::string(R"({"host": "10.0.0.10", )") + GetParam().options + "}";
  const ConfigNode node = support::config_of(std::string_view(text));
  ConfigReader reader(node, "networks.knx", errors);
  EXPECT_FALSE(kType.make({"knx", IslandId{1}, reader, types, {}}, host));
  EXPECT_THAT(errors.text(), HasSubstr(GetParam().error));
}

INSTANTIATE_TEST_SUITE_P(
    Options, WrongSecureOptions,
    testing::Values(
        WrongOption{R"("keyring": "none.knxkeys", "keyring-password-file": "house.password")", "none.knxkeys"},
        WrongOption{R"("keyring": "broken.knxkeys", "keyring-password-file": "house.password")", "broken.knxkeys"},
        WrongOption{R"("keyring": "house.knxkeys")", "keyring-password-file: is missing"},
        WrongOption{R"("keyring": "house.knxkeys", "keyring-password-file": "open.password")", "chmod"},
        WrongOption{R"("keyring": "house.knxkeys", "keyring-password-file": "house.password",
                       "server-address": "1.1.300")",
                    "server-address"},
        WrongOption{R"("keyring": "house.knxkeys", "keyring-password-file": "house.password",
                       "user-password-file": "user.password")",
                    "expected one of them"},
        WrongOption{R"("keyring-password-file": "house.password")", "without 'keyring'"},
        WrongOption{R"("user": 4)", "without 'user-password-file'"},
        WrongOption{R"("user": 1, "user-password-file": "user.password")", "user"},
        WrongOption{R"("user": 200, "user-password-file": "user.password")", "user"},
        WrongOption{R"("secure": "require")", "require needs"}, WrongOption{R"("secure": "yes")", "secure"},
        WrongOption{R"("secure": "off", "user-password-file": "user.password")", "is off, although"},
        WrongOption{R"("backbone-key-file": "short.key")", "is an option of routing"},
        WrongOption{R"("via": "routing", "backbone-key-file": "short.key")", "32 hexadecimal digits"},
        WrongOption{R"("via": "routing", "latency": "2s")", "without 'backbone-key-file'"},
        WrongOption{R"("via": "routing", "user": 3)", "is an option of tunnels"},
        WrongOption{R"("group-keys-file": "none.keys")", "none.keys"},
        WrongOption{R"("group-keys-file": "short.key")", "short.key: line 1: the address is not followed by a key"},
        WrongOption{R"("group-keys-file": "house.password", "secure": "require")", "require needs"},
        WrongOption{R"("group-keys-file": "open.password")", "chmod"}));

}  // namespace
}  // namespace rubicon::networks::knx
