#include <cstdlib>

#include "networks/knx/secure/passwords.h"
#include "networks/knx/secure_bench.h"
#include "support/memory/memory_worker.h"

namespace rubicon::networks::knx {
namespace {

using model::LineState;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// When and where the keys of a network are derived.
class KnxKeys : public SecureKnx {
 protected:
  /// The transports of the host, with a worker that computes when the test wants.
  struct Slow final : transport::Transports {
    explicit Slow(support::FakeHost& h) : host(h) {}
    Result<std::unique_ptr<transport::FileSource>> open_file(const std::string& path) override {
      return host.files.open_file(path);
    }
    Result<std::unique_ptr<transport::TcpStream>> open_tcp(const transport::TcpOptions& options,
                                                           transport::TcpCallbacks calls) override {
      return host.files.open_tcp(options, std::move(calls));
    }
    Result<std::unique_ptr<transport::UdpSocket>> open_udp(const transport::UdpOptions& options,
                                                           transport::UdpCallbacks calls) override {
      return host.files.open_udp(options, std::move(calls));
    }
    std::unique_ptr<transport::Lookup> look_up(const std::string& name, transport::LookupDone done) override {
      return host.files.look_up(name, std::move(done));
    }
    Result<std::unique_ptr<transport::Worker>> start_worker(const std::string&) override {
      if (fails) return fail(ErrorCode::kIo, "no room for a thread");
      auto made = std::make_unique<transport::MemoryWorker>(host.time);
      worker = made.get();
      worker->hold();
      return made;
    }

    support::FakeHost& host;
    transport::MemoryWorker* worker = nullptr;
    bool fails = false;
  };
  KnxKeys() { host.lines = &slow; }

  Slow slow{host};
};

TEST_F(KnxKeys, AreDerivedApartFromTheLoop) {
  start(kSecureHouse);
  ASSERT_NE(slow.worker, nullptr);
  EXPECT_EQ(last_state().line, LineState::kConnecting);
  EXPECT_THAT(last_state().reason, HasSubstr("derives the keys"));
  const auto refused = send(model::Actuate{5, point(Kind::kActuator, "temperature"), 21.5}, "2/0/1");
  EXPECT_EQ(refused.error().code, ErrorCode::kUnreachable) << "commands are answered meanwhile";
  host.time.run_for(1min);
  EXPECT_EQ(network->reopen().error().code, ErrorCode::kUnsupported);
  slow.worker->release();
  host.time.run_for(1s);
  EXPECT_EQ(last_state().line, LineState::kUp) << last_state().reason;
}

TEST_F(KnxKeys, MayBeLeftBehind) {
  start(kSecureHouse);
  network.reset();
  host.delivered.clear();
  host.time.run_for(1min);
  EXPECT_THAT(host.delivered, IsEmpty());
}

TEST_F(KnxKeys, ChangesAreTakenWhileTheyAreDerived) {
  start(kSecureHouse);
  std::string other(kSecureHouse);
  other.replace(other.find("Garden"), 6, "Terrace");
  ASSERT_TRUE(change(other));
  slow.worker->release();
  host.time.run_for(1s);
  EXPECT_EQ(last_state().line, LineState::kUp) << last_state().reason;
}

TEST_F(KnxKeys, WithoutAThreadTheHostTriesAgain) {
  slow.fails = true;
  make(kSecureHouse);
  const auto opened = network->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().text, "no room for a thread");
  host.time.run_for(1min);
  for (const auto& [device, state] : host.all<model::State>()) EXPECT_NE(state.line, LineState::kConnecting);
  slow.fails = false;
  ASSERT_TRUE(network->open());
  slow.worker->release();
  host.time.run_for(1s);
  EXPECT_EQ(last_state().line, LineState::kUp) << last_state().reason;
}

TEST_F(SecureKnx, AnAttemptThatAUserWantsDerivesTheKeysAgain) {
  host.files.put("house.password", "another word\n");
  start(kSecureHouse);
  ASSERT_EQ(last_state().line, LineState::kRefused);
  EXPECT_EQ(count("attempts"), 0U);
  ASSERT_TRUE(network->reopen());
  host.time.run_for(1s);
  EXPECT_EQ(last_state().line, LineState::kRefused);
  EXPECT_EQ(count("attempts"), 1U);
}

TEST_F(SecureKnx, AnAttemptBeforeThereIsALineIsRefused) {
  make(kSecureHouse);
  EXPECT_EQ(network->reopen().error().code, ErrorCode::kUnsupported);
  ASSERT_TRUE(network->open());
  EXPECT_EQ(network->reopen().error().code, ErrorCode::kUnsupported);
}

TEST_F(SecureKnx, AChangeOfPointsIsTakenWhileTheKeyringIsRefused) {
  host.files.put("house.password", "another word\n");
  start(kSecureHouse);
  std::string other(kSecureHouse);
  other.replace(other.find("Garden"), 6, "Terrace");
  EXPECT_TRUE(change(other));
  EXPECT_EQ(last_state().line, LineState::kRefused);
}

TEST_F(SecureKnx, AReloadWithTheRightPasswordOpensTheLine) {
  host.files.put("house.password", "another word\n");
  start(kSecureHouse);
  ASSERT_EQ(last_state().line, LineState::kRefused);
  host.files.put("house.password", "ring word\n");
  ASSERT_EQ(change(kSecureHouse).error().code, ErrorCode::kUnsupported) << "the network is made again";
  start(kSecureHouse);
  EXPECT_EQ(last_state().line, LineState::kUp) << last_state().reason;
}

TEST_F(SecureKnx, ThePasswordOfTheKeyringMayStandInTheEnvironment) {
  std::string house(kSecureHouse);
  const std::string option = R"("keyring-password-file": "house.password",)";
  house.erase(house.find(option), option.size());
  ::setenv(secure::kPasswordVariable, "ring word", 1);
  start(house);
  ::unsetenv(secure::kPasswordVariable);
  EXPECT_EQ(last_state().line, LineState::kUp) << last_state().reason;
}

TEST_F(SecureKnx, OfSeveralInterfacesOneIsNamed) {
  auto root = support::keyring_root();
  for (const auto* host_address : {"1.1.0", "1.2.0"}) {
    const bool first = std::string_view(host_address) == "1.1.0";
    support::KeyringElement tunnel{"Interface"};
    tunnel.text("Type", "Tunneling").text("IndividualAddress", first ? "1.1.201" : "1.2.201");
    tunnel.text("Host", host_address).text("UserID", first ? "4" : "3");
    root.add(tunnel.password("Password", "four").password("Authentication", "the device"));
  }
  host.files.put("house.knxkeys", support::write_keyring(root, "ring word"));
  start(kSecureHouse);
  EXPECT_EQ(last_state().line, LineState::kRefused);
  EXPECT_THAT(last_state().reason, HasSubstr("several interfaces"));
  std::string house(kSecureHouse);
  start(house.insert(1, R"("server-address": "1.1.0", )"));
  EXPECT_EQ(last_state().line, LineState::kUp) << last_state().reason;
}

/// The keyring lists our own address as a sender of the group.
TEST_F(SecureKnx, OurOwnTelegramIsNotTakenForThatOfADevice) {
  std::string house(kSecureHouse);
  house.replace(house.find(R"("kind": "actuator")"), 18, R"("kind": "actuator", "listen": ["2/0/1"])");
  start(house);
  command(21.5);
  const auto sent = heard();
  ASSERT_EQ(sent.size(), 1U);
  wire::DataFrame frame;
  frame.code = wire::CemiCode::kDataIndication;
  frame.control1 &= 0x7f;
  frame.source = wire::IndividualAddress(0x11c9);
  frame.destination = 0x1001;
  frame.tpdu = sent[0];
  const auto before = count("data-secure-received");
  secure_server->inject_cemi(wire::write(frame));
  host.time.run_for(3s);
  EXPECT_EQ(count("data-secure-received"), before);
  EXPECT_EQ(count("data-secure-old"), 1U);
}

}  // namespace
}  // namespace rubicon::networks::knx
