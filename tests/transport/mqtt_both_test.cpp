#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "support/memory/mqtt_broker.h"
#include "support/mosquitto.h"
#include "support/private_network.h"
#include "transport/mqtt_client.h"
#include "transport/worlds.h"

namespace rubicon::transport {
namespace {

using support::Mosquitto;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

/// What a broker is asked to be.
struct BrokerKind {
  std::map<std::string, std::string> users{};
  std::optional<MqttRights> rights{};
  std::optional<std::size_t> max_queued{}, largest_packet{}, largest_payload{};
  bool retains = true;
  std::optional<Duration> longest_keep_alive{};
};

support::MosquittoOptions as_mosquitto(const BrokerKind& setup) {
  support::MosquittoOptions options;
  options.users = setup.users;
  if (setup.rights) options.acl = setup.rights->text();
  const auto add = [&](const char* name, auto value) { options.more += fmt::format("{} {}\n", name, value); };
  if (setup.max_queued) add("max_queued_messages", *setup.max_queued);
  if (setup.largest_packet) add("max_packet_size", *setup.largest_packet);
  if (setup.largest_payload) add("message_size_limit", *setup.largest_payload);
  if (!setup.retains) add("retain_available", "false");
  if (setup.longest_keep_alive)
    add("max_keepalive", std::chrono::floor<std::chrono::seconds>(*setup.longest_keep_alive).count());
  return options;
}

/// The same on the broker in memory and on mosquitto: the first one does what the second one does.
class BothBrokers : public ::testing::TestWithParam<Where> {
 protected:
  bool in_memory() const { return GetParam() == Where::kMemory; }
  void SetUp() override {
    world = make_world(GetParam());
    if (in_memory()) return;
    network = std::make_unique<support::PrivateNetwork>();
    if (!network->entered()) GTEST_SKIP() << network->reason();
    if (const auto missing = Mosquitto::missing(); !missing.empty()) GTEST_SKIP() << missing;
    apart = std::make_unique<MachineWorld>();
  }
  void start(const BrokerKind& setup = {}) {
    if (in_memory()) return start_in_memory(setup);
    mosquitto = std::make_unique<Mosquitto>(as_mosquitto(setup));
    ASSERT_TRUE(world->until([&] { return mosquitto->ready(); })) << mosquitto->errors();
  }
  void start_in_memory(const BrokerKind& setup) {
    broker = std::make_unique<MqttBroker>(static_cast<MemoryWorld&>(*world).net, Endpoint{"127.0.0.1", 1883});
    broker->users = setup.users;
    broker->rights = setup.rights;
    broker->max_queued = setup.max_queued.value_or(broker->max_queued);
    broker->largest_packet = setup.largest_packet.value_or(broker->largest_packet);
    broker->largest_payload = setup.largest_payload.value_or(broker->largest_payload);
    broker->retains = setup.retains;
    broker->longest_keep_alive = setup.longest_keep_alive.value_or(broker->longest_keep_alive);
  }
  /// As `user`, whose password is `secret`; empty = without one.
  static MqttOptions options(MqttVersion version = MqttVersion::k5, const std::string& user = "") {
    MqttOptions made;
    made.host = "127.0.0.1";
    made.version = version;
    made.connect_time = 30s;  // a loaded machine
    made.user = user;
    if (!user.empty()) made.password = "secret";
    return made;
  }
  void connect(MqttClient& client, const MqttOptions& with) {
    client.open(world->transports(), with);
    ASSERT_TRUE(world->until([&] { return client.connected > 0 || !client.failures.empty(); }));
    ASSERT_THAT(client.failures, IsEmpty()) << client.failures[0].text;
  }
  Error failure(const MqttOptions& with) {
    MqttClient client;
    client.open(world->transports(), with);
    EXPECT_TRUE(world->until([&] { return !client.failures.empty() || client.connected > 0; }));
    EXPECT_EQ(client.connected, 0);
    return client.failures.empty() ? Error{} : client.failures[0];
  }
  void subscribe(MqttClient& client, const std::string& filter, std::uint8_t qos = 0) {
    const auto before = client.subscribed.size();
    ASSERT_TRUE(client.line->subscribe(filter, qos));
    ASSERT_TRUE(world->until([&] { return client.subscribed.size() > before; }));
  }
  /// Until this arrived, and so all before.
  bool hears(const MqttClient& client, const std::string& last) {
    return world->until([&] { return !client.received.empty() && client.received.back() == last; });
  }

  std::unique_ptr<World> world;
  std::unique_ptr<support::PrivateNetwork> network;
  std::unique_ptr<MachineWorld> apart;  ///< a loop that stands still, if there is a machine
  std::unique_ptr<Mosquitto> mosquitto;
  std::unique_ptr<MqttBroker> broker;
  MqttClient ann, bob;
};

TEST_P(BothBrokers, GrantedSubscriptionsAreToldBeforeTheirRetainedMessages) {
  start();
  connect(bob, options());
  for (int i = 0; i < 100; ++i)
    ASSERT_TRUE(bob.line->publish({"p/" + std::to_string(i), "x", true, static_cast<std::uint8_t>(i % 2)}));
  ASSERT_TRUE(bob.line->publish({"q", "x", true, 1}));
  ASSERT_TRUE(world->until([&] { return bob.taken.size() == 51; }));
  connect(ann, options());
  for (const auto* filter : {"in", "q", "p/+"}) ASSERT_TRUE(ann.line->subscribe(filter));
  ASSERT_TRUE(ann.line->publish({"in", "fence"}));
  ASSERT_TRUE(hears(ann, "in fence"));
  EXPECT_THAT(ann.subscribed, ElementsAre("in", "q", "p/+"));
  ASSERT_THAT(ann.order, SizeIs(3 + 101 + 1));
  EXPECT_EQ(ann.order[0], "+in");
  const auto at = [&](const char* what) { return std::find(ann.order.begin(), ann.order.end(), what); };
  EXPECT_LT(at("+q"), at("q x*"));
  for (int i = 0; i < 100; ++i) EXPECT_LT(at("+p/+"), at(fmt::format("p/{} x*", i).c_str()));
  EXPECT_EQ(ann.order.back(), "in fence") << "after all that is retained";
  ASSERT_TRUE(ann.line->subscribe("q"));
  EXPECT_TRUE(hears(ann, "q x*")) << "asked again: sent again";
}

TEST_P(BothBrokers, OutcomesHaveTheirNumberAndReason) {
  start();
  for (const auto version : {MqttVersion::k5, MqttVersion::k311}) {
    MqttClient client;
    connect(client, options(version));
    EXPECT_EQ(client.connack.version, version);
    const auto publish = [&](std::uint64_t number, bool retain) {
      MqttPublication message{"a", "1", retain, 1};
      message.number = number;
      ASSERT_TRUE(client.line->publish(std::move(message)));
      ASSERT_TRUE(world->until([&] { return client.outcomes.back().starts_with(std::to_string(number)); }));
    };
    client.outcomes.emplace_back();
    publish(7, false);
    publish(8, true);
    subscribe(client, "a");
    publish(9, false);
    const auto* nobody = version == MqttVersion::k5 ? "16" : "0";
    EXPECT_THAT(client.outcomes, ElementsAre("", std::string("7 ") + nobody, std::string("8 ") + nobody, "9 0"));
    EXPECT_THAT(client.taken, SizeIs(3));
    EXPECT_THAT(client.not_taken, IsEmpty());
  }
}

TEST_P(BothBrokers, OverlappingFiltersBringAMessageTwice) {
  start();
  connect(ann, options());
  for (const auto* filter : {"a/+", "a/b", "end"}) subscribe(ann, filter);
  ASSERT_TRUE(ann.line->publish({"a/b", "1"}));
  ASSERT_TRUE(ann.line->publish({"end", ""}));
  ASSERT_TRUE(hears(ann, "end "));
  EXPECT_THAT(ann.received, ElementsAre("a/b 1", "a/b 1", "end "));
}

BrokerKind with_rights() {
  return {.users = {{"hall", "secret"}, {"lab", "secret"}, {"hall/c1", "secret"}},
          .rights = MqttRights{{"s/+/p/#", "s/+/to/%u/#", "end"}, {"s/+/p/+/%u/#", "s/+/to/+/+/%u/+", "end"}}};
}

TEST_P(BothBrokers, PatternsOfRightsHold) {
  start(with_rights());
  connect(ann, options(MqttVersion::k5, "hall"));
  for (const auto* filter : {"s/1/p/#", "s/1/to/hall/#", "end"}) subscribe(ann, filter);
  for (const auto version : {MqttVersion::k5, MqttVersion::k311}) {
    MqttClient lab;
    connect(lab, options(version, "lab"));
    subscribe(lab, "s/1/to/#");
    EXPECT_THAT(lab.refused, IsEmpty()) << "granted, and silent";
    ann.received.clear();
    for (const auto* topic : {"s/1/p/3/lab/x", "s/1/p/3/hall/x", "s/1/to/hall/x/lab/y", "s/1/to/hall/x/hall/y"}) {
      ASSERT_TRUE(lab.line->publish({topic, "1", false, 1}));
      ASSERT_TRUE(lab.line->publish({topic, "0"}));
    }
    ASSERT_TRUE(ann.line->publish({"s/1/to/ann/x/hall/y", "not for lab"}));
    ASSERT_TRUE(lab.line->publish({"end", "", false, 1}));
    ASSERT_TRUE(hears(ann, "end "));
    ASSERT_TRUE(world->until([&] { return lab.outcomes.size() == 5; }));
    EXPECT_THAT(ann.received, ElementsAre("s/1/p/3/lab/x 1", "s/1/p/3/lab/x 0", "s/1/to/hall/x/lab/y 1",
                                          "s/1/to/hall/x/lab/y 0", "end "));
    const bool says_so = version == MqttVersion::k5;
    EXPECT_THAT(lab.not_taken, SizeIs(says_so ? 2 : 0));
    for (const auto& one : lab.not_taken) EXPECT_THAT(one, HasSubstr("0x87"));
    EXPECT_EQ(std::count(lab.outcomes.begin(), lab.outcomes.end(), "0 135"), says_so ? 2 : 0);
    EXPECT_THAT(lab.received, IsEmpty());
    EXPECT_THAT(lab.failures, IsEmpty());
  }
}

TEST_P(BothBrokers, AUserWithASlashWritesWhereOthersMay) {
  start(with_rights());
  connect(ann, options(MqttVersion::k5, "lab"));
  subscribe(ann, "s/1/p/#");
  connect(bob, options(MqttVersion::k5, "hall/c1"));
  ASSERT_TRUE(bob.line->publish({"s/1/p/3/hall/c1", "forged"}));
  EXPECT_TRUE(hears(ann, "s/1/p/3/hall/c1 forged"));
}

TEST_P(BothBrokers, AForbiddenWillIsNeverPublished) {
  start(with_rights());
  connect(ann, options(MqttVersion::k5, "hall"));
  for (const auto* filter : {"s/1/p/#", "end"}) subscribe(ann, filter);
  for (const auto* of : {"hall", "lab"}) {
    auto with_will = options(MqttVersion::k5, "lab");
    with_will.client_id = "lab1";
    with_will.will = MqttWill{std::string("s/1/p/3/") + of, "gone", false};
    MqttClient lab, other;
    connect(lab, with_will);
    with_will.will.reset();
    connect(other, with_will);
    ASSERT_TRUE(world->until([&] { return !lab.failures.empty(); }));
    ASSERT_TRUE(other.line->publish({"end", of}));
    ASSERT_TRUE(hears(ann, std::string("end ") + of));
  }
  EXPECT_THAT(ann.received, ElementsAre("end hall", "s/1/p/3/lab gone", "end lab"));
}

TEST_P(BothBrokers, TheSameClientIdTakesOverAndAnEmptyWillRemovesWhatIsRetained) {
  start();
  connect(bob, options());
  subscribe(bob, "p/#");
  subscribe(bob, "end");
  for (const auto qos : {std::uint8_t{0}, std::uint8_t{1}}) {
    auto with_will = options();
    with_will.client_id = "same";
    with_will.will = MqttWill{"p/ann", "", true, qos};
    MqttClient first, second;
    connect(first, with_will);
    ASSERT_TRUE(first.line->publish({"p/ann", "here", true, 1}));
    ASSERT_TRUE(world->until([&] { return first.taken.size() == 1; }));
    with_will.will.reset();
    connect(second, with_will);
    ASSERT_TRUE(world->until([&] { return !first.failures.empty(); }));
    EXPECT_THAT(first.failures,
                ElementsAre(Error{ErrorCode::kUnreachable, "MQTT 127.0.0.1:1883: the broker closed the connection"}))
        << "without a reason";
    subscribe(second, "p/#");
    subscribe(second, "end");
    ASSERT_TRUE(second.line->publish({"end", std::to_string(qos)}));
    ASSERT_TRUE(hears(second, "end " + std::to_string(qos)));
    ASSERT_TRUE(hears(bob, "end " + std::to_string(qos)));
    EXPECT_THAT(second.received, SizeIs(1)) << "nothing is retained";
    EXPECT_THAT(bob.received, ElementsAre("p/ann here", "p/ann ", "end " + std::to_string(qos)));
    bob.received.clear();
  }
}

TEST_P(BothBrokers, WhatIsRetainedExpires) {
  start();
  connect(bob, options());
  ASSERT_TRUE(bob.line->publish({"p/kept", "1", true}));
  ASSERT_TRUE(bob.line->publish({"p/long", "1", true, 0, MqttQueue::kInOrder, 1h}));
  ASSERT_TRUE(bob.line->publish({"p/short", "1", true, 1, MqttQueue::kInOrder, 8s}));
  ASSERT_TRUE(world->until([&] { return bob.taken.size() == 1; }));
  connect(ann, options());
  subscribe(ann, "end");
  std::vector<std::string> found;
  const auto look = [&] {
    ann.received.clear();
    subscribe(ann, "p/+");
    ASSERT_TRUE(ann.line->publish({"end", ""}));
    ASSERT_TRUE(hears(ann, "end "));
    ann.received.pop_back();
    found = ann.received;
  };
  look();
  EXPECT_THAT(found, SizeIs(3));
  for (int i = 0; i < 100'000 && found.size() > 2; ++i) {
    int turns = 0;
    world->until([&] { return ++turns > 20; });
    look();
  }
  EXPECT_THAT(found, UnorderedElementsAre("p/kept 1*", "p/long 1*"));
}

TEST_P(BothBrokers, AnAnswerIsWantedInVersion5Only) {
  start();
  connect(bob, options());
  connect(ann, options());
  MqttClient old;
  connect(old, options(MqttVersion::k311));
  subscribe(ann, "ask");
  subscribe(old, "ask");
  MqttPublication question{"ask", "1", false, 1, MqttQueue::kInOrder, 1h};
  question.response_topic = "answers/bob";
  question.correlation = std::string("1\0 7", 4);
  ASSERT_TRUE(bob.line->publish(question));
  ASSERT_TRUE(hears(ann, "ask 1"));
  ASSERT_TRUE(hears(old, "ask 1"));
  EXPECT_THAT(ann.asked, ElementsAre("answers/bob|" + question.correlation + "|3600"));
  EXPECT_THAT(old.asked, IsEmpty());
}

TEST_P(BothBrokers, ALongPacketIsToldAPayloadThatIsTooLongIsNot) {
  start({.largest_packet = 5000, .largest_payload = 1000});
  connect(ann, options());
  subscribe(ann, "#");
  for (const auto version : {MqttVersion::k5, MqttVersion::k311}) {
    MqttClient client;
    connect(client, options(version));
    const bool modern = version == MqttVersion::k5;
    EXPECT_EQ(client.connack.largest_packet, modern ? 5000U : 0U);
    ASSERT_TRUE(client.line->publish({"a", std::string(2000, 'x'), false, 1}));
    ASSERT_TRUE(client.line->publish({"a", std::string(2000, 'x')}));
    ASSERT_TRUE(client.line->publish({"end", "", false, 1}));
    ASSERT_TRUE(world->until([&] { return client.outcomes.size() == 2; }));
    EXPECT_THAT(client.outcomes, ElementsAre(modern ? "0 149" : "0 0", "0 0"));
    ASSERT_THAT(client.not_taken, SizeIs(modern ? 1 : 0));
    for (const auto& one : client.not_taken) EXPECT_THAT(one, HasSubstr("larger than it takes (reason 0x95)"));
    ASSERT_TRUE(hears(ann, "end "));
    EXPECT_THAT(ann.received, Each("end "));
    const auto longer = client.line->publish({"a", std::string(6000, 'x')});
    if (modern) {
      EXPECT_EQ(longer.error().code, ErrorCode::kOutOfRange);
      EXPECT_THAT(client.failures, IsEmpty());
    } else {
      ASSERT_TRUE(world->until([&] { return !client.failures.empty(); }));
      EXPECT_EQ(client.failures[0].code, ErrorCode::kUnreachable);
    }
  }
}

TEST_P(BothBrokers, ABrokerThatRetainsNothingIsRecognised) {
  start({.retains = false});
  auto with_will = options();
  with_will.will = MqttWill{"p/ann", ""};
  EXPECT_EQ(failure(with_will).code, ErrorCode::kUnsupported);
  with_will.version = MqttVersion::k311;
  EXPECT_EQ(failure(with_will).code, ErrorCode::kUnreachable) << "it just closes the connection";
  connect(ann, options());
  EXPECT_FALSE(ann.connack.retains);
  subscribe(ann, "p/+");
  ASSERT_TRUE(ann.line->publish({"p/ann", "1", true}));
  ASSERT_TRUE(hears(ann, "p/ann 1")) << "sent on";
  subscribe(ann, "p/ann");
  ASSERT_TRUE(ann.line->publish({"p/end", ""}));
  ASSERT_TRUE(hears(ann, "p/end ")) << "and not kept";
  EXPECT_THAT(ann.received, SizeIs(2));
  connect(bob, options(MqttVersion::k311));
  EXPECT_TRUE(bob.connack.retains) << "not told";
  ASSERT_TRUE(bob.line->publish({"p/bob", "1", true}));
  EXPECT_TRUE(world->until([&] { return !bob.failures.empty(); }));
}

TEST_P(BothBrokers, TheKeepAliveOfTheBrokerCounts) {
  start({.longest_keep_alive = 10s});
  auto with = options();
  with.client_id = "ann";
  connect(ann, with);
  EXPECT_EQ(ann.connack.keep_alive, 10s);
  EXPECT_TRUE(ann.connack.retains);
  with.keep_alive = 5s;
  with.client_id = "bob";
  connect(bob, with);
  EXPECT_EQ(bob.connack.keep_alive, 5s);
}

/// More than the buffers of a machine take: 4 MiB of the line, and up to 6 and 4 MiB of the system.
TEST_P(BothBrokers, WhatASubscriberDoesNotReadIsDroppedSilently) {
  constexpr std::size_t kSent = 1000;
  for (const auto qos : {std::uint8_t{0}, std::uint8_t{1}}) {
    start({.max_queued = 10});
    auto& still = in_memory() ? *world : *apart;
    auto with = options();
    with.client_id = "slow";
    MqttClient slow, quick;
    slow.open(still.transports(), with);
    ASSERT_TRUE(slow.line->subscribe("a", qos));
    ASSERT_TRUE(still.until([&] { return slow.subscribed.size() == 1; }));
    if (in_memory()) broker->stall("slow", true);
    connect(quick, options());
    for (std::size_t i = 0; i < kSent; ++i) {
      ASSERT_TRUE(quick.line->publish({"a", std::to_string(i) + ' ' + std::string(32'000, 'x'), false, 1}));
      ASSERT_TRUE(world->until([&] { return quick.taken.size() + 20 > i; }));
    }
    ASSERT_TRUE(world->until([&] { return quick.taken.size() == kSent; }));
    EXPECT_THAT(quick.not_taken, IsEmpty()) << "nobody is told";
    EXPECT_THAT(quick.outcomes, Each("0 0"));
    if (in_memory()) broker->stall("slow", false);
    // The first ones are dropped too: it has not read the others yet.
    for (int i = 0; i < 1000 && (slow.received.empty() || slow.received.back() != "a end"); ++i) {
      ASSERT_TRUE(quick.line->publish({"a", "end", false, 1}));
      ASSERT_TRUE(world->until([&] { return quick.taken.size() == kSent + static_cast<std::size_t>(i) + 1; }));
      int turns = 0;
      still.until([&] { return ++turns > 20; });
    }
    const auto end = std::find(slow.received.begin(), slow.received.end(), "a end");
    ASSERT_NE(end, slow.received.end());
    const auto got = static_cast<std::size_t>(end - slow.received.begin());
    EXPECT_LT(got, kSent);
    std::vector<std::size_t> numbers;
    for (auto one = slow.received.begin(); one != end; ++one) numbers.push_back(std::stoul(one->substr(2)));
    EXPECT_TRUE(std::is_sorted(numbers.begin(), numbers.end())) << "with gaps, if the system's buffers grow";
    if (in_memory()) {
      EXPECT_EQ(got, qos == 0 ? 10U : 30U);
      EXPECT_EQ(numbers.back(), got - 1) << "the newest are dropped";
    }
    mosquitto.reset();
    broker.reset();
  }
}

TEST_P(BothBrokers, WhatIsRetainedIsBoundedAtQos1Only) {
  start({.max_queued = 10});
  connect(bob, options());
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(bob.line->publish({"p/" + std::to_string(i), "x", true, 1}));
  ASSERT_TRUE(world->until([&] { return bob.taken.size() == 500; }));
  connect(ann, options());
  subscribe(ann, "end", 1);
  for (const auto qos : {std::uint8_t{0}, std::uint8_t{1}}) {
    ann.received.clear();
    subscribe(ann, "p/+", qos);
    const auto end = "end " + std::to_string(qos);
    for (int i = 0; i < 1000 && (ann.received.empty() || ann.received.back() != end); ++i) {
      ASSERT_TRUE(ann.line->publish({"end", std::to_string(qos), false, qos})) << "may be dropped too";
      int turns = 0;
      world->until([&] { return ++turns > 20; });
    }
    const auto got = std::count_if(ann.received.begin(), ann.received.end(),
                                   [](const auto& one) { return one.starts_with("p/") && one.ends_with('*'); });
    EXPECT_EQ(got, qos == 0 ? 500 : 30);
  }
}

INSTANTIATE_TEST_SUITE_P(InAll, BothBrokers, ::testing::Values(Where::kMemory, Where::kMachine),
                         [](const auto& one) { return name_of(one.param); });

}  // namespace
}  // namespace rubicon::transport
