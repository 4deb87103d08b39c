#include "model/findings.h"
#include "networks/knx/knx_line.h"
#include "networks/knx/line/tunnel_line.h"
#include "networks/knx/secure_bench.h"

namespace rubicon::networks::knx {
namespace {

using model::LineState;
using model::Outcome;
using support::KeyringElement;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

/// A house with secured groups behind a plain interface, which gives the tunnel 1.1.200 to each client.
class PlainInterface : public SecureKnx {
 protected:
  PlainInterface() { host.files.put("house.knxkeys", keyring_of("1.1.200")); }

  static std::string keyring_of(const char* linked) {
    auto root = support::keyring_root();
    KeyringElement interface { "Interface" };
    interface.text("Type", "Tunneling").text("IndividualAddress", linked).text("Host", "1.1.0");
    interface.add(KeyringElement{"Group"}.text("Address", "4097").text("Senders", "1.1.30"));
    root.add(interface.add(KeyringElement{"Group"}.text("Address", "2567").text("Senders", "1.1.30")));
    KeyringElement groups{"GroupAddresses"};
    for (const auto* number : {"2567", "4097"})
      groups.add(KeyringElement{"Group"}.text("Address", number).key("Key", kGroupKey));
    return support::write_keyring(root.add(groups), "ring word");
  }
  /// The house with these further options and a plain tunnel.
  static std::string plain_house(const std::string& more) {
    std::string house(kSecureHouse);
    const std::string via = R"({"via": "tunnel-tcp", "host": "10.0.0.10",)";
    return house.replace(0, via.size(), R"({"host": "10.0.0.9", )" + more);
  }
  std::vector<Bytes> heard_plainly() const {
    std::vector<Bytes> all;
    for (const auto& one : server.heard())
      if (one.destination == group("2/0/1")) all.push_back(one.tpdu);
    return all;
  }
};

TEST_F(PlainInterface, SecuredGroupsAreReadAndWrittenFromTheAddressThatItGives) {
  start(plain_house(R"("secure": "off",)"));
  ASSERT_EQ(last_state().line, LineState::kUp) << last_state().reason;
  EXPECT_EQ(last_state().reason, "");
  server.inject_cemi(from_device(0x0a07, {0x0c, 0x33}));
  command(21.5);
  EXPECT_THAT(values_of("1/2/7"), ElementsAre("21.5"));
  EXPECT_THAT(outcomes(), ElementsAre(Outcome::kSent));
  ASSERT_THAT(heard_plainly(), SizeIs(1));
  EXPECT_EQ(heard_plainly()[0][1], 0xf1) << "secured";
}

TEST_F(PlainInterface, ItIsWrittenFromNoOtherAddress) {
  host.files.put("house.knxkeys", keyring_of("1.1.205"));
  start(plain_house(R"("secure": "off",)"));
  command(21.5);
  EXPECT_THAT(outcomes(), ElementsAre(Outcome::kRefused));
  EXPECT_THAT(heard_plainly(), SizeIs(0));
}

TEST_F(PlainInterface, IsRefusedWithTheRemedyWhereALineMustBeSecure) {
  start(plain_house(""));
  EXPECT_EQ(last_state().line, LineState::kRefused);
  EXPECT_THAT(last_state().reason, AllOf(HasSubstr("its interfaces are plain"), HasSubstr("`secure: off`")));
  EXPECT_EQ(last_state().finding, model::findings::kKeyringPlainTunnels);
  EXPECT_EQ(server.counters.connects, 0U);
}

TEST_F(PlainInterface, IsAllowedAndNamed) {
  start(plain_house(R"("secure": "allow",)"));
  EXPECT_EQ(last_state().line, LineState::kUp);
  EXPECT_EQ(last_state().reason, "the line is plain: the keyring has no tunnel with a user and a password");
  EXPECT_EQ(last_state().finding, model::findings::kPlainLine);
  EXPECT_TRUE(host.words.contains("the line is plain"));
  command(21.5);
  EXPECT_THAT(outcomes(), ElementsAre(Outcome::kSent));
}

TEST_F(PlainInterface, IsNotAllowedWhereAnAddressIsNamed) {
  for (const auto* named : {R"("tunnel-address": "1.1.200",)", R"("server-address": "1.1.0",)"}) {
    start(plain_house(std::string(R"("secure": "allow",)") + named));
    EXPECT_EQ(last_state().line, LineState::kRefused) << named;
  }
  EXPECT_EQ(server.counters.connects, 0U);
}

/// An interface with the tunnels 1.1.201 and 1.1.202 of the users 2 and 3, and another client of it.
class TwoTunnels : public SecureKnx {
 protected:
  TwoTunnels() {
    knx_simulator::SecureOptions secured;
    secured.device_code = secure::device_code(secure::Secret::of_text("the device"))->key;
    secured.users = {{2, key_of_user("two"), 0x11c9}, {3, key_of_user("three"), 0x11ca}};
    support::KnxServer::Options options;
    options.at = {"10.0.0.11", 3671};
    options.wanted_addresses = true;
    options.secure = std::move(secured);
    two = std::make_unique<support::KnxServer>(host.time, host.net, options);
    keyring("two", "three");
    house.replace(house.find("10.0.0.10"), 9, "10.0.0.11");
  }
  void keyring(const char* password_of_201, const char* password_of_202) {
    auto root = support::keyring_root();
    root.add(tunnel("1.1.201", "2", password_of_201));
    root.add(tunnel("1.1.202", "3", password_of_202));
    host.files.put("house.knxkeys", support::write_keyring(root, "ring word"));
  }
  static KeyringElement tunnel(const char* address, const char* user, const char* password) {
    KeyringElement one{"Interface"};
    one.text("Type", "Tunneling").text("IndividualAddress", address).text("Host", "1.1.0").text("UserID", user);
    return one.password("Password", password).password("Authentication", "the device");
  }
  std::unique_ptr<line::TunnelLine> client(std::uint8_t user, const char* password) {
    line::TunnelOptions options;
    options.host = "10.0.0.11";
    options.via = line::TunnelOptions::Via::kTcp;
    options.secure = secure::SessionKeys{user, secure::user_key(secure::Secret::of_text(password)).value(), {}};
    auto made = std::make_unique<line::TunnelLine>(std::move(options), host.time, host.files, line::LineCallbacks());
    EXPECT_TRUE(made->open());
    host.time.run_for(1s);
    EXPECT_EQ(made->state().phase, line::LineState::Phase::kUp) << made->state().reason;
    return made;
  }

  std::unique_ptr<support::KnxServer> two;
  std::string house{kSecureHouse};
};

TEST_F(TwoTunnels, TheFirstFreeOneIsTaken) {
  const auto other = client(2, "two");
  start(house);
  host.time.run_for(1s);
  EXPECT_EQ(last_state().line, LineState::kUp) << last_state().reason;
  EXPECT_EQ(last_state().texts.at("tunnel-address"), "1.1.202");
}

TEST_F(TwoTunnels, WithoutAFreeOneBothAreNamedAndTriedAgain) {
  auto first = client(2, "two");
  const auto second = client(3, "three");
  start(house);
  host.time.run_for(10s);
  EXPECT_EQ(last_state().line, LineState::kRefused);
  EXPECT_THAT(last_state().reason,
              AllOf(HasSubstr("all tunnels of the keyring are in use"), HasSubstr("1.1.201, 1.1.202")));
  first.reset();
  host.time.run_for(3min);
  EXPECT_EQ(last_state().line, LineState::kUp) << last_state().reason;
  EXPECT_EQ(last_state().reason, "");
  EXPECT_EQ(last_state().texts.at("tunnel-address"), "1.1.201");
}

TEST_F(TwoTunnels, OneWhosePasswordIsRefusedIsSkipped) {
  keyring("wrong", "three");
  start(house);
  host.time.run_for(10s);
  EXPECT_EQ(last_state().line, LineState::kUp) << last_state().reason;
  EXPECT_EQ(last_state().texts.at("tunnel-address"), "1.1.202");
  EXPECT_TRUE(host.words.contains("the tunnel 1.1.201 is skipped until the line is opened again"));
}

TEST_F(TwoTunnels, OneWhosePasswordIsRefusedKeepsNobodyFromTheOthers) {
  keyring("two", "wrong");
  auto other = client(2, "two");
  start(house);
  host.time.run_for(1min);
  EXPECT_EQ(last_state().line, LineState::kRefused);
  EXPECT_THAT(last_state().reason, HasSubstr("the interface refuses the user of 1.1.202"));
  other.reset();
  host.time.run_for(3min);
  EXPECT_EQ(last_state().line, LineState::kUp) << last_state().reason;
  EXPECT_EQ(last_state().texts.at("tunnel-address"), "1.1.201");
}

TEST_F(TwoTunnels, WhereAllPasswordsAreRefusedTheyAreTriedAgainInTurn) {
  keyring("wrong", "wrong");
  start(house);
  host.time.run_for(1min);
  EXPECT_EQ(last_state().line, LineState::kRefused);
  keyring("two", "three");
  const auto before = two->counters.connects;
  host.time.run_for(1h);
  EXPECT_EQ(two->counters.connects, before) << "no connection without a password";
  EXPECT_LT(count("attempts"), 100U) << "no hurry";
}

TEST(TunnelRound, WhereTheUsersOfAllAreRefusedAllAreTriedAgain) {
  TunnelRound round;
  for (const auto* tunnel : {"1.1.201", "1.1.202"}) round.user_refused(wire::parse_individual(tunnel).value());
  EXPECT_THAT(round.unusable(), SizeIs(2));
  EXPECT_FALSE(round.end(true, {}));
  EXPECT_THAT(round.unusable(), SizeIs(0));
}

TEST_F(TwoTunnels, ANamedOneIsWaitedFor) {
  auto other = client(2, "two");
  house.insert(1, R"("tunnel-address": "1.1.201", )");
  start(house);
  host.time.run_for(1min);
  EXPECT_EQ(last_state().line, LineState::kRefused);
  EXPECT_THAT(last_state().reason, HasSubstr("in use"));
  other.reset();
  host.time.run_for(3min);
  EXPECT_EQ(last_state().texts.at("tunnel-address"), "1.1.201");
}

/// Interfaces 1.1.0 at 10.0.0.10, with the tunnel 1.1.201 of user 4, and 1.2.0 at 10.0.0.12, with the tunnels 1.2.201
/// and 1.2.202 of the users 2 and 3. One keyring has all; the second has a password of its own.
class GatewaysOfAKeyring : public SecureKnx {
 protected:
  GatewaysOfAKeyring() {
    knx_simulator::SecureOptions secured;
    secured.device_code = secure::device_code(secure::Secret::of_text("the other device"))->key;
    secured.users = {{2, key_of_user("two"), 0x12c9}, {3, key_of_user("three"), 0x12ca}};
    support::KnxServer::Options options;
    options.at = {"10.0.0.12", 3671};
    options.first_address = 0x12c8;
    options.wanted_addresses = true;
    options.secure = std::move(secured);
    second = std::make_unique<support::KnxServer>(host.time, host.net, options);
    auto root = support::keyring_root();
    root.add(tunnel("1.1.201", "1.1.0", "4", "four", "the device"));
    root.add(tunnel("1.2.201", "1.2.0", "2", "two", "the other device"));
    root.add(tunnel("1.2.202", "1.2.0", "3", "three", "the other device"));
    host.files.put("house.knxkeys", support::write_keyring(root, "ring word"));
    house.replace(house.find("\"10.0.0.10\""), 11,
                  R"(["10.0.0.10", "10.0.0.12"], "server-address": ["1.1.0", "1.2.0"], "gateway-check": "1min")");
  }
  static KeyringElement tunnel(const char* address, const char* server, const char* user, const char* password,
                               const char* device) {
    KeyringElement one{"Interface"};
    one.text("Type", "Tunneling").text("IndividualAddress", address).text("Host", server).text("UserID", user);
    return one.password("Password", password).password("Authentication", device);
  }
  /// What a supervisor does after a loss.
  void supervise(Duration time) {
    for (const auto end = host.time.now() + time; host.time.now() < end; host.time.run_for(100ms)) {
      if (std::exchange(answered, host.failures.size()) != host.failures.size()) std::ignore = network->open();
    }
  }
  std::string used() const { return last_state().texts.at("gateway"); }

  std::unique_ptr<support::KnxServer> second;
  std::string house{kSecureHouse};
  std::size_t answered = 0;
};

TEST_F(GatewaysOfAKeyring, EachIsOpenedWithItsOwnUsersAndPasswords) {
  start(house);
  supervise(1s);
  ASSERT_EQ(last_state().line, LineState::kUp) << last_state().reason;
  EXPECT_EQ(used(), "10.0.0.10 (preferred)");
  EXPECT_EQ(last_state().texts.at("tunnel-address"), "1.1.201");
  secure_server->stop();
  supervise(5min);
  ASSERT_EQ(last_state().line, LineState::kUp) << last_state().reason;
  EXPECT_EQ(used(), "10.0.0.12 (instead of 10.0.0.10)");
  EXPECT_EQ(last_state().texts.at("tunnel-address"), "1.2.201");
  EXPECT_EQ(count("gateway-changes"), 1U);
  secure_server->start();
  supervise(3min);
  EXPECT_EQ(used(), "10.0.0.10 (preferred)");
  EXPECT_EQ(last_state().texts.at("tunnel-address"), "1.1.201");
}

TEST_F(GatewaysOfAKeyring, TheNextTunnelIsThatOfTheSameInterfaceWhereOneIsTaken) {
  line::TunnelOptions options;
  options.host = "10.0.0.12";
  options.via = line::TunnelOptions::Via::kTcp;
  options.secure = secure::SessionKeys{2, secure::user_key(secure::Secret::of_text("two")).value(), {}};
  line::TunnelLine other(std::move(options), host.time, host.files, line::LineCallbacks());
  ASSERT_TRUE(other.open());
  host.time.run_for(1s);
  secure_server->stop();
  start(house);
  supervise(1min);
  ASSERT_EQ(last_state().line, LineState::kUp) << last_state().reason;
  EXPECT_EQ(used(), "10.0.0.12 (instead of 10.0.0.10)");
  EXPECT_EQ(last_state().texts.at("tunnel-address"), "1.2.202");
}

TEST_F(SecureKnx, AllowIsSecureWhereTheKeyringHasATunnel) {
  std::string house(kSecureHouse);
  start(house.insert(1, R"("secure": "allow", )"));
  EXPECT_EQ(last_state().line, LineState::kUp) << last_state().reason;
  EXPECT_EQ(last_state().reason, "");
  EXPECT_EQ(count("secure-sessions"), 1U);
}

TEST_F(SecureKnx, AllowDoesNotBecomePlainByATypingError) {
  std::string house(kSecureHouse);
  start(house.insert(1, R"("secure": "allow", "tunnel-address": "1.1.99", )"));
  EXPECT_EQ(last_state().line, LineState::kRefused);
  EXPECT_THAT(last_state().reason, HasSubstr("no tunnel 1.1.99"));
  EXPECT_EQ(last_state().finding, model::findings::kKeyringNoTunnel);
  EXPECT_EQ(secure_server->counters.connects, 0U);
}

TEST_F(SecureKnx, AllowedRoutingWithoutABackboneKeyIsPlainAndNamed) {
  start(R"({"via": "routing", "interface": "127.0.0.1", "keyring": "house.knxkeys", "secure": "allow",
            "keyring-password-file": "house.password"})");
  host.time.run_for(10s);
  EXPECT_EQ(last_state().line, LineState::kUp);
  EXPECT_THAT(last_state().reason, HasSubstr("the line is plain: the keyring has no backbone key"));
}

}  // namespace
}  // namespace rubicon::networks::knx
