#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "model/findings.h"
#include "support/mosquitto.h"
#include "support/private_network.h"
#include "transport/mqtt_client.h"
#include "transport/worlds.h"

namespace rubicon::transport {
namespace {

using support::Certificates;
using support::Mosquitto;
using support::MosquittoListener;
using support::MosquittoOptions;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

/// Lines to a real mosquitto in a network of its own.
class LiveBroker : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!network.entered()) GTEST_SKIP() << network.reason();
    if (const auto missing = Mosquitto::missing(); !missing.empty()) GTEST_SKIP() << missing;
    world = std::make_unique<MachineWorld>();
  }
  void start(MosquittoOptions options = {}) {
    broker = std::make_unique<Mosquitto>(std::move(options));
    ASSERT_TRUE(world->until([&] { return broker->ready(); })) << broker->errors();
  }
  static MqttOptions options(MqttVersion version = MqttVersion::kAny) {
    MqttOptions made;
    made.host = "127.0.0.1";
    made.version = version;
    made.connect_time = 30s;  // a loaded machine
    return made;
  }
  void connect(MqttClient& client, const MqttOptions& with) {
    client.open(world->local, with);
    ASSERT_TRUE(world->until([&] { return client.connected > 0 || !client.failures.empty(); }));
    ASSERT_THAT(client.failures, IsEmpty()) << client.failures[0].text;
  }
  /// The only failure of a line that is opened now.
  Error failure(const MqttOptions& with) {
    MqttClient client;
    client.open(world->local, with);
    EXPECT_TRUE(world->until([&] { return !client.failures.empty() || client.connected > 0; }));
    EXPECT_EQ(client.connected, 0);
    return client.failures.empty() ? Error{} : client.failures[0];
  }

  support::PrivateNetwork network;
  std::unique_ptr<MachineWorld> world;
  std::unique_ptr<Mosquitto> broker;
  MqttClient ann, bob;
};

TEST_F(LiveBroker, MessagesGoBothWaysInBothVersions) {
  start();
  ASSERT_EQ(broker->publish("a/b", "old", {"-r"}).code, 0);
  for (const auto version : {MqttVersion::k311, MqttVersion::k5}) {
    MqttClient client;
    client.open(world->local, options(version));
    ASSERT_TRUE(client.line->subscribe("a/+", 1)) << "may be asked before the connection is there";
    ASSERT_TRUE(world->until([&] { return client.received.size() == 1; }));
    EXPECT_EQ(client.connected, 1);
    ASSERT_TRUE(client.line->publish({"a/c", "mine", false, 1}));
    ASSERT_TRUE(world->until([&] { return client.received.size() == 2; }));
    ASSERT_EQ(broker->publish("a/b", "new").code, 0);
    ASSERT_TRUE(world->until([&] { return client.received.size() == 3; }));
    EXPECT_THAT(client.received, ElementsAre("a/b old*", "a/c mine", "a/b new"));
    EXPECT_EQ(client.line->counters().received, 3U);
    EXPECT_EQ(client.line->counters().sent, 1U);
    ASSERT_TRUE(client.line->unsubscribe("a/+"));
    ASSERT_TRUE(client.line->subscribe("end"));
    ASSERT_TRUE(client.line->publish({"a/d", "not received"}));
    ASSERT_TRUE(client.line->publish({"end", ""}));
    ASSERT_TRUE(world->until([&] { return client.received.size() >= 4; })) << client.failures.size();
    EXPECT_EQ(client.received[3], "end ");
  }
}

TEST_F(LiveBroker, ThousandsOfMessagesArriveInOrder) {
  start();
  connect(ann, options());
  ASSERT_TRUE(ann.line->subscribe("n"));
  std::size_t next = 0;
  for (; next < 9000; ++next)
    ASSERT_TRUE(ann.line->publish({"n", std::to_string(next), false, static_cast<std::uint8_t>(next % 2)}));
  ASSERT_TRUE(world->until([&] { return ann.received.size() == next; }));
  for (std::size_t i = 0; i < next; ++i) ASSERT_EQ(ann.received[i], "n " + std::to_string(i));
  EXPECT_EQ(ann.line->counters().sent, next);
  EXPECT_EQ(ann.line->counters().not_taken, 0U);
}

TEST_F(LiveBroker, PacketsOfOursAndOfTheLibraryDoNotMix) {
  const Certificates certificates;
  ASSERT_EQ(certificates.reason(), "");
  for (const bool tls : {false, true}) {
    start({.tls = tls ? &certificates : nullptr});
    auto with = options();
    if (tls) with.tls = MqttTls{certificates.path("ca.pem"), {}, {}, "broker.test"};
    MqttClient client;
    connect(client, with);
    ASSERT_TRUE(client.line->subscribe("n", 1));
    std::vector<std::string> expected;
    for (std::size_t i = 0; i < 900; ++i) {
      const auto text = std::to_string(i) + std::string(i * 37 % 9000, 'x');
      ASSERT_TRUE(client.line->publish({"n", text, false, static_cast<std::uint8_t>(i / 7 % 2)}));
      expected.push_back("n " + text);
    }
    EXPECT_TRUE(world->until([&] { return client.received.size() >= expected.size() || !client.failures.empty(); }));
    EXPECT_EQ(client.received, expected) << (tls ? "with TLS" : "without");
  }
}

TEST_F(LiveBroker, ManyFiltersAreAskedTogether) {
  start();
  connect(ann, options());
  const std::string longer(200, 'x');
  for (int i = 0; i < 500; ++i)
    ASSERT_TRUE(ann.line->subscribe(std::to_string(i) + longer, static_cast<std::uint8_t>(i % 2)));
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(ann.line->publish({std::to_string(i) + longer, "1"}));
  EXPECT_TRUE(world->until([&] { return ann.received.size() == 500; })) << ann.received.size();
}

TEST_F(LiveBroker, AClosedLineSendsWhatWaitsAndHasNoWill) {
  start();
  MosquittoListener listener(*broker, "#");
  auto with_will = options();
  with_will.will = MqttWill{"online", "offline"};
  with_will.client_id = "rubicon1";
  connect(ann, with_will);
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(ann.line->publish({"bye", std::to_string(i), false, 1}));
  ann.line.reset();
  world.reset();  // the process ends here: the loop does not run again
  for (int i = 0; i < 20; ++i) ASSERT_EQ(listener.next(), "bye " + std::to_string(i));
  ASSERT_EQ(broker->publish("end", "1").code, 0);
  EXPECT_EQ(listener.next(), "end 1") << "no will";
}

TEST_F(LiveBroker, ASecondClientWithTheSameIdTakesOverAndTheWillIsPublished) {
  start();
  MosquittoListener listener(*broker, "#");
  auto same = options();
  same.will = MqttWill{"online", "offline"};
  same.client_id = "rubicon1";
  connect(ann, same);
  connect(bob, same);
  ASSERT_TRUE(world->until([&] { return !ann.failures.empty(); }));
  EXPECT_THAT(ann.failures, SizeIs(1)) << "mosquitto 2.0.11 does not say why";
  EXPECT_THAT(bob.failures, IsEmpty());
  EXPECT_EQ(ann.line->publish({"a", "b"}).error().code, ErrorCode::kUnreachable);
  EXPECT_EQ(listener.next(), "online offline");
}

/// Of the sockets of this process that are connected to this port: how many, and how many have TCP_NODELAY.
std::pair<int, int> connections_to(std::uint16_t port) {
  std::pair<int, int> found{};
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int descriptor = std::stoi(entry.path().filename());
    sockaddr_in peer{};
    socklen_t size = sizeof peer;
    if (::getpeername(descriptor, reinterpret_cast<sockaddr*>(&peer), &size) != 0 || peer.sin_family != AF_INET)
      continue;
    if (ntohs(peer.sin_port) != port) continue;
    int at_once = 0;
    socklen_t length = sizeof at_once;
    ::getsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &at_once, &length);
    ++found.first;
    if (at_once != 0) ++found.second;
  }
  return found;
}

TEST_F(LiveBroker, SmallMessagesAreNotHeldBack) {
  start();
  connect(ann, options());
  EXPECT_EQ(connections_to(broker->port()), std::pair(1, 1));
  ann.line.reset();
  const Certificates certificates;
  ASSERT_EQ(certificates.reason(), "");
  start({.port = 8883, .tls = &certificates});
  auto with = options();
  with.port = 8883;
  with.tls = MqttTls{certificates.path("ca.pem"), {}, {}, "broker.test"};
  connect(bob, with);
  EXPECT_EQ(connections_to(8883), std::pair(1, 1));
}

TEST_F(LiveBroker, AWrongPasswordIsRefusedAndNotRepeated) {
  start({.users = {{"rubicon", "right"}}});
  for (const auto version : {MqttVersion::kAny, MqttVersion::k311, MqttVersion::k5}) {
    auto with = options(version);
    with.user = "rubicon";
    with.password = "s3cret";
    const auto why = failure(with);
    EXPECT_EQ(why.code, ErrorCode::kRefused) << why.text;
    EXPECT_THAT(why.text, AllOf(HasSubstr("not authorised"), Not(HasSubstr("s3cret"))));
    EXPECT_EQ(failure(options(version)).code, ErrorCode::kRefused) << "no user";
    with.password = "right";
    MqttClient client;
    connect(client, with);
  }
}

TEST_F(LiveBroker, TheCertificateOfTheBrokerIsChecked) {
  const Certificates certificates;
  ASSERT_EQ(certificates.reason(), "");
  start({.tls = &certificates});
  auto with = options();
  with.tls = MqttTls{certificates.path("ca.pem"), {}, {}, "broker.test"};
  ann.open(world->local, with);
  ASSERT_TRUE(ann.line->subscribe("a", 1));
  ASSERT_TRUE(world->until([&] { return ann.connected > 0 || !ann.failures.empty(); }));
  ASSERT_THAT(ann.failures, IsEmpty()) << ann.failures[0].text;
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(ann.line->publish({"a", std::string(1000, 'x'), false, 1}));
  EXPECT_TRUE(world->until([&] { return ann.received.size() == 500; }));
  std::string_view finding;
  const auto refused = [&](const char* ca, const char* name) {
    with.tls = MqttTls{ca == nullptr ? "" : certificates.path(ca), {}, {}, name};
    const auto why = failure(with);
    EXPECT_EQ(why.code, ErrorCode::kRefused);
    finding = why.finding;
    return why.text;
  };
  EXPECT_THAT(refused("ca.pem", "elsewhere.test"),
              HasSubstr("not accepted: hostname mismatch (expected elsewhere.test)"));
  EXPECT_EQ(finding, model::findings::kCertificateName);
  EXPECT_THAT(refused("ca.pem", ""), HasSubstr("IP address mismatch (expected 127.0.0.1)"));
  EXPECT_THAT(refused("other_ca.pem", "broker.test"), HasSubstr("self-signed certificate in certificate chain"));
  EXPECT_EQ(finding, model::findings::kCertificateAuthority);
  EXPECT_THAT(refused(nullptr, "broker.test"), HasSubstr("not accepted: ")) << "the system does not know our authority";
  with.tls = MqttTls{certificates.path("none.pem"), {}, {}, {}};
  const auto none = failure(with);
  EXPECT_EQ(none.code, ErrorCode::kNotFound);
  EXPECT_THAT(none.text, HasSubstr("none.pem: cannot read: No such file"));
  with.tls = MqttTls{certificates.path("server.key"), {}, {}, {}};
  EXPECT_EQ(failure(with).code, ErrorCode::kInvalid);
  EXPECT_THAT(failure(options()).text, HasSubstr("does it expect TLS?"));
  EXPECT_EQ(failure(options()).finding, model::findings::kTlsExpected);
  broker->kill();
  ASSERT_TRUE(world->until([&] { return !ann.failures.empty(); }));
  EXPECT_THAT(ann.failures[0].text, HasSubstr("the broker closed the connection"));
}

TEST_F(LiveBroker, TheBrokerMayAskForOurCertificate) {
  const Certificates certificates;
  ASSERT_EQ(certificates.reason(), "");
  start({.tls = &certificates, .asks_for_certificate = true});
  auto with = options();
  with.tls = MqttTls{certificates.path("ca.pem"), certificates.path("client.pem"), certificates.path("client.key"),
                     "broker.test"};
  connect(ann, with);
  with.tls->key_file = certificates.path("server.key");
  EXPECT_THAT(failure(with).text, HasSubstr("key values mismatch"));
  for (const auto* encrypted : {"encrypted.key", "encrypted.pkcs8"}) {
    with.tls->key_file = certificates.path(encrypted);
    const auto why = failure(with);
    EXPECT_EQ(why.code, ErrorCode::kInvalid);
    EXPECT_THAT(why.text, HasSubstr(std::string(encrypted) + ": is encrypted"));
  }
  with.tls->certificate_file = with.tls->key_file = "";
  // The broker may close the connection before its reason arrives.
  EXPECT_THAT(failure(with).text, AnyOf(HasSubstr("certificate required"), HasSubstr("does it want our certificate")));
}

TEST_F(LiveBroker, TlsToAPlainBrokerFails) {
  start();
  auto with = options();
  with.tls = MqttTls{};
  EXPECT_THAT(failure(with).text, HasSubstr("(does it speak TLS"));
}

TEST_F(LiveBroker, RefusedSubscriptionsAndPublicationsAreReported) {
  start({.refused_filters = {"secret/#"}, .forbidden_topics = {"forbidden/#"}});
  for (const auto version : {MqttVersion::k311, MqttVersion::k5}) {
    MqttClient client;
    connect(client, options(version));
    for (const auto* filter : {"open/#", "secret/#", "more/#"}) ASSERT_TRUE(client.line->subscribe(filter));
    ASSERT_TRUE(client.line->publish({"forbidden/a", "1", false, 1}));
    ASSERT_TRUE(client.line->publish({"open/a", "1", false, 1}));
    const bool says_so = version == MqttVersion::k5;
    ASSERT_TRUE(world->until([&] {
      const auto answered = client.taken.size() + client.not_taken.size();
      return client.received.size() == 1 && client.refused.size() == 1 && answered == 2;
    }));
    EXPECT_EQ(client.taken,
              says_so ? std::vector<std::string>{"open/a"} : (std::vector<std::string>{"forbidden/a", "open/a"}));
    EXPECT_THAT(client.refused, ElementsAre("secret/#"));
    EXPECT_THAT(client.received, ElementsAre("open/a 1"));
    EXPECT_EQ(client.line->counters().not_taken, says_so ? 1U : 0U) << "3.1.1 does not report it";
    ASSERT_EQ(client.not_taken.size(), says_so ? 1U : 0U);
    for (const auto& one : client.not_taken) EXPECT_THAT(one, AllOf(HasSubstr("forbidden/a "), HasSubstr("0x87")));
  }
}

/// The names that mosquitto and its library refuse.
TEST_F(LiveBroker, WrongNamesAndFiltersDoNotEndTheConnection) {
  start();
  connect(ann, options());
  std::string deep = "a";
  for (int i = 0; i < 250; ++i) deep += "/a";
  const std::vector<std::string> wrong{"a\xc2\x85", "a\x7f", "a\x01", "a\xef\xbf\xbf", "a\xef\xb7\x90", deep};
  for (const auto& name : wrong) {
    EXPECT_EQ(ann.line->subscribe(name).error().code, ErrorCode::kInvalid) << name;
    EXPECT_EQ(ann.line->unsubscribe(name).error().code, ErrorCode::kInvalid) << name;
    EXPECT_EQ(ann.line->publish({name, "1"}).error().code, ErrorCode::kInvalid) << name;
  }
  ASSERT_TRUE(ann.line->subscribe("Küche/\xf0\x9f\x92\xa1/#"));
  ASSERT_TRUE(ann.line->publish({"Küche/\xf0\x9f\x92\xa1/on", "1"}));
  ASSERT_TRUE(world->until([&] { return !ann.received.empty() || !ann.failures.empty(); }));
  EXPECT_THAT(ann.failures, IsEmpty());
  EXPECT_EQ(ann.line->counters().not_taken, 0U);
}

TEST_F(LiveBroker, SubscriptionsFitIntoThePacketsOfTheBroker) {
  start({.more = "max_packet_size 4096\n"});
  connect(ann, options(MqttVersion::k5));
  const std::string longer(100, 'x'), longest(5000, 'y');
  ASSERT_TRUE(ann.line->subscribe("0" + longer));
  ASSERT_TRUE(ann.line->subscribe(longest));
  for (int i = 1; i < 200; ++i) ASSERT_TRUE(ann.line->subscribe(std::to_string(i) + longer));
  for (int i = 0; i < 200; ++i) ASSERT_TRUE(ann.line->publish({std::to_string(i) + longer, "1"}));
  EXPECT_TRUE(world->until([&] { return ann.received.size() == 200; })) << ann.received.size();
  EXPECT_THAT(ann.refused, ElementsAre(longest));
  EXPECT_THAT(ann.failures, IsEmpty());
}

TEST_F(LiveBroker, ABrokerThatWasKilledIsReachedAgain) {
  start({.persistent = true});
  ASSERT_EQ(broker->publish("kept", "1", {"-r", "-q", "1"}).code, 0);
  broker->stop();
  for (int i = 0; i < 3; ++i) {
    EXPECT_THAT(failure(options()).text, HasSubstr("Connection refused"));
    broker->start();
    ASSERT_TRUE(world->until([&] { return broker->ready(); }));
    MqttClient client;
    connect(client, options());
    ASSERT_TRUE(client.line->subscribe("kept"));
    ASSERT_TRUE(world->until([&] { return client.received.size() == 1; }));
    broker->kill();
    ASSERT_TRUE(world->until([&] { return !client.failures.empty(); }));
    EXPECT_EQ(client.failures[0].code, ErrorCode::kUnreachable);
    EXPECT_THAT(client.failures, SizeIs(1));
  }
}

/// The most memory that this process ever had since the last call, in bytes.
std::size_t peak_memory() {
  std::ifstream status("/proc/self/status");
  std::size_t peak = 0;
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) peak = std::stoul(line.substr(6)) * 1024;
  std::ofstream("/proc/self/clear_refs") << "5";
  return peak;
}

TEST_F(LiveBroker, AHugePacketIsDropped) {
  start();
  const auto file = std::filesystem::temp_directory_path() / ("rubicon-huge-" + std::to_string(::getpid()));
  std::ofstream(file).close();
  std::filesystem::resize_file(file, 100'000'000);  // has no blocks on the disk
  connect(ann, options(MqttVersion::k5));
  ASSERT_TRUE(ann.line->subscribe("#"));
  ASSERT_TRUE(ann.line->publish({"ready", ""}));
  ASSERT_TRUE(world->until([&] { return ann.received.size() == 1; }));
  peak_memory();
  const auto before = peak_memory();
  ASSERT_EQ(broker->publish("huge", "", {"-f", file.string()}).code, 0);
  ASSERT_EQ(broker->publish("after", "1").code, 0);
  ASSERT_TRUE(world->until([&] { return ann.received.size() == 2; }));
  EXPECT_EQ(ann.received.back(), "after 1");
  EXPECT_EQ(ann.line->counters().too_long, 0U) << "a broker of version 5 does not send it";
  EXPECT_LT(peak_memory(), before + 20'000'000);
  MqttClient old;
  connect(old, options(MqttVersion::k311));
  ASSERT_TRUE(old.line->subscribe("#"));
  ASSERT_TRUE(old.line->publish({"ready", ""}));
  ASSERT_TRUE(world->until([&] { return old.received.size() == 1; }));
  ASSERT_EQ(broker->publish("huge", "", {"-f", file.string()}).code, 0);
  ASSERT_EQ(broker->publish("after", "2").code, 0);
  ASSERT_TRUE(world->until([&] { return old.received.size() == 2; }));
  EXPECT_EQ(old.received.back(), "after 2");
  EXPECT_EQ(old.line->counters().too_long, 1U);
  EXPECT_THAT(old.too_long, ElementsAre(AllOf(HasSubstr("huge 1000000"), Not(HasSubstr("after")))));
  EXPECT_THAT(ann.too_long, IsEmpty());
  std::filesystem::remove(file);
}

TEST_F(LiveBroker, TheBrokerSaysWhichPacketsItTakes) {
  start({.more = "max_packet_size 2000\n"});
  connect(ann, options(MqttVersion::k5));
  const auto refused = ann.line->publish({"a", std::string(3000, 'x')});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kOutOfRange);
}

TEST_F(LiveBroker, MoreThanMayBeUnderWayArrivesAfterAll) {
  start();
  connect(ann, options());
  connect(bob, options());
  const std::string large(1'000'000, 'x');
  for (int i = 0; i < 40; ++i) {
    ASSERT_TRUE(bob.line->publish({"large/" + std::to_string(i), large, true, 1}));
    ASSERT_TRUE(world->until([&] { return bob.line->counters().sent == static_cast<std::uint64_t>(i) + 1; }));
  }
  ASSERT_TRUE(ann.line->subscribe("large/+"));
  ASSERT_TRUE(world->until([&] { return ann.received.size() == 40; }));
}

TEST_F(LiveBroker, ALineMayBeDestroyedInEachOfItsCalls) {
  start({.refused_filters = {"b"}});
  ASSERT_EQ(broker->publish("a", "1", {"-r"}).code, 0);
  for (const auto* in : {"connected", "received", "refused", "failed"}) {
    std::unique_ptr<MqttLine> line;
    const auto end = [&](std::string_view call) {
      EXPECT_NE(line, nullptr) << "no call after the end: " << call;
      if (call == in) line.reset();
    };
    MqttCallbacks calls;
    calls.connected = [&](const auto&) { end("connected"); };
    calls.received = [&](const auto&) { end("received"); };
    calls.refused = [&](auto, const auto&) { end("refused"); };
    calls.failed = [&](const auto&) { end("failed"); };
    line = *world->local.open_mqtt(options(), calls);
    ASSERT_TRUE(line->subscribe("b"));
    ASSERT_TRUE(line->subscribe("a"));
    if (std::string_view(in) == "failed") {
      ASSERT_TRUE(world->until([&] { return broker->ready(); }));
      broker->kill();
    }
    ASSERT_TRUE(world->until([&] { return line == nullptr; })) << in;
  }
}

}  // namespace
}  // namespace rubicon::transport
