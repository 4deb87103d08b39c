#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/virtual_scheduler.h"
#include "support/memory/memory_transports.h"
#include "support/memory/mqtt_broker.h"
#include "transport/mqtt.h"
#include "transport/mqtt_client.h"
#include "transport/mqtt_exchange.h"

namespace rubicon::transport {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class MemoryBroker : public ::testing::Test {
 protected:
  MemoryBroker() { memory.join(net); }
  MqttOptions options(const std::string& id = "") const {
    MqttOptions made;
    made.host = "localhost";
    made.client_id = id;
    return made;
  }
  void connect(MqttClient& client, const MqttOptions& with) {
    client.open(memory, with);
    time.run_for(10ms);
    ASSERT_EQ(client.connected, 1);
  }

  VirtualScheduler time;
  MemoryNet net{time};
  MemoryTransports memory;
  MqttBroker broker{net, {"127.0.0.1", 1883}};
  MqttClient ann, bob;
};

TEST_F(MemoryBroker, PassesMessagesBetweenClientsInOrder) {
  connect(ann, options());
  connect(bob, options());
  ASSERT_TRUE(ann.line->subscribe("a/+"));
  for (const auto* payload : {"1", "2", "3"}) ASSERT_TRUE(bob.line->publish({"a/b", payload}));
  ASSERT_TRUE(bob.line->publish({"c/d", "4"}));
  time.run_for(1s);
  EXPECT_THAT(ann.received, ElementsAre("a/b 1", "a/b 2", "a/b 3"));
  EXPECT_THAT(broker.published("c/d"), ElementsAre("4"));
  EXPECT_THAT(broker.subscriptions(), ElementsAre("a/+"));
  EXPECT_EQ(ann.line->counters().received, 3U);
  EXPECT_EQ(bob.line->counters().sent, 4U);
  ASSERT_TRUE(ann.line->unsubscribe("a/+"));
  time.run_for(1s);
  EXPECT_THAT(broker.subscriptions(), IsEmpty());
}

TEST_F(MemoryBroker, SendsWhatIsRetainedWhichSurvivesARestartOnlyIfKept) {
  broker.publish("a/b", "old", true);
  ann.open(memory, options());
  ASSERT_TRUE(ann.line->subscribe("#")) << "may be asked before the connection is there";
  time.run_for(1s);
  EXPECT_THAT(ann.received, ElementsAre("a/b old*"));
  broker.publish("a/b", "new", true);
  time.run_for(1s);
  EXPECT_THAT(ann.received, ElementsAre("a/b old*", "a/b new")) << "a live message has no mark";
  broker.stop(true);
  EXPECT_EQ(broker.retained("a/b"), "new");
  broker.stop(false);
  EXPECT_EQ(broker.retained("a/b"), std::nullopt);
  broker.start();
  broker.publish("a/b", "x", true);
  broker.publish("a/b", "", true);
  EXPECT_THAT(broker.retained(), IsEmpty());
}

TEST_F(MemoryBroker, PublishesTheWillOfALostLineButNotOfAClosedOne) {
  auto with_will = options("ann");
  with_will.will = MqttWill{"ann/online", "offline"};
  connect(ann, with_will);
  ann.line.reset();
  time.run_for(1s);
  EXPECT_THAT(broker.published(), IsEmpty());
  EXPECT_THAT(broker.clients(), IsEmpty());
  connect(bob, with_will);
  broker.cut("ann");
  time.run_for(1s);
  EXPECT_EQ(broker.retained("ann/online"), "offline");
  ASSERT_THAT(broker.published(), SizeIs(1));
  EXPECT_TRUE(broker.published()[0].will);
  EXPECT_THAT(bob.failures,
              ElementsAre(Error{ErrorCode::kUnreachable, "MQTT localhost:1883: the broker closed the connection"}));
}

TEST_F(MemoryBroker, SendsWhatWaitsBeforeItCloses) {
  connect(ann, options());
  ASSERT_TRUE(ann.line->publish({"bye", "1"}));
  ann.line.reset();
  time.run_for(1s);
  EXPECT_THAT(broker.published("bye"), ElementsAre("1"));
}

TEST_F(MemoryBroker, RefusesUsersFiltersAndVersion5) {
  broker.users = {{"rubicon", "secret"}};
  auto wrong = options();
  wrong.user = "rubicon";
  wrong.password = "wrong";
  ann.open(memory, wrong);
  time.run_for(1s);
  ASSERT_THAT(ann.failures, SizeIs(1));
  EXPECT_EQ(ann.failures[0].code, ErrorCode::kRefused);
  EXPECT_THAT(ann.failures[0].text, HasSubstr("refuses the user or the password"));
  EXPECT_EQ(ann.line->publish({"a", "b"}).error().code, ErrorCode::kUnreachable);
  auto right = wrong;
  right.password = "secret";
  broker.speaks_5 = false;
  broker.refused_filters = {"secret/#"};
  connect(bob, right);
  ASSERT_TRUE(bob.line->subscribe("secret/#"));
  time.run_for(1s);
  EXPECT_THAT(bob.refused, ElementsAre("secret/#"));
  EXPECT_THAT(broker.subscriptions(), IsEmpty());
  right.version = MqttVersion::k5;
  MqttClient modern;
  modern.open(memory, right);
  time.run_for(1s);
  ASSERT_THAT(modern.failures, SizeIs(1));
  EXPECT_THAT(modern.failures[0].text, HasSubstr("does not speak this version"));
}

TEST_F(MemoryBroker, GivesUpOnABrokerThatSaysNothingOrIsNotThere) {
  broker.answers = false;
  ann.open(memory, options());
  time.run_for(9s);
  EXPECT_THAT(ann.failures, IsEmpty());
  time.run_for(2s);
  ASSERT_THAT(ann.failures, SizeIs(1));
  EXPECT_THAT(ann.failures[0].text, HasSubstr("no answer within 10 s"));
  broker.stop(true);
  bob.open(memory, options());
  time.run_for(1s);
  ASSERT_THAT(bob.failures, SizeIs(1));
  EXPECT_THAT(bob.failures[0].text, HasSubstr("Connection refused"));
  EXPECT_EQ(bob.failures[0].code, ErrorCode::kUnreachable);
}

TEST_F(MemoryBroker, AStalledLineQueuesWithinItsBoundsAndIsLostInTheEnd) {
  auto with_will = options("ann");
  with_will.will = MqttWill{"ann/online", "offline"};
  connect(ann, with_will);
  broker.stall(true);
  for (int i = 0; i < 100; ++i)
    ASSERT_TRUE(ann.line->publish({"state", std::to_string(i), true, 0, MqttQueue::kLatest}));
  ASSERT_TRUE(ann.line->publish({"event", std::string(MqttLine::kMaxQueuedBytes - 1000, 'x')}));
  EXPECT_EQ(ann.line->publish({"event", std::string(2000, 'x')}).error().code, ErrorCode::kBusy);
  time.run_for(10s);
  EXPECT_THAT(broker.published(), IsEmpty());
  broker.stall(false);
  time.run_for(1s);
  EXPECT_THAT(broker.published("state"), ElementsAre("99"));
  EXPECT_THAT(broker.published("event"), SizeIs(1));
  broker.stall(true);
  time.run_for(31s);
  EXPECT_THAT(ann.failures, SizeIs(1));
  EXPECT_EQ(broker.retained("ann/online"), "offline");
}

TEST_F(MemoryBroker, LongPacketsAreNotSentToVersion5AndCountedOn311) {
  auto narrow = options();
  narrow.largest_packet = 2000;
  connect(ann, narrow);
  auto old = narrow;
  old.version = MqttVersion::k311;
  connect(bob, old);
  for (auto* client : {&ann, &bob}) ASSERT_TRUE(client->line->subscribe("#"));
  time.run_for(1s);
  broker.publish("a", std::string(3000, 'x'));
  time.run_for(1s);
  EXPECT_EQ(ann.line->counters().too_long, 0U);
  EXPECT_EQ(bob.line->counters().too_long, 1U);
  EXPECT_THAT(ann.too_long, IsEmpty());
  EXPECT_THAT(bob.too_long, ElementsAre("a 3009"));
  EXPECT_THAT(bob.received, IsEmpty());
  broker.largest_packet = 1000;
  EXPECT_EQ(ann.line->publish({"a", std::string(1500, 'x')}).error().code, ErrorCode::kOutOfRange);
  ASSERT_TRUE(bob.line->publish({"a", std::string(1500, 'x')})) << "3.1.1 announces no limit";
  time.run_for(1s);
  EXPECT_THAT(bob.failures, SizeIs(1));
}

TEST_F(MemoryBroker, ASecondClientWithTheSameIdTakesOver) {
  connect(ann, options("same"));
  connect(bob, options("same"));
  time.run_for(1s);
  ASSERT_THAT(ann.failures, SizeIs(1));
  EXPECT_EQ(ann.failures[0].code, ErrorCode::kUnreachable);
  EXPECT_THAT(bob.failures, IsEmpty());
  EXPECT_THAT(broker.clients(), ElementsAre("same"));
  broker.tells_take_over = true;
  MqttClient third;
  connect(third, options("same"));
  ASSERT_THAT(bob.failures, SizeIs(1));
  EXPECT_EQ(bob.failures[0].code, ErrorCode::kDuplicate);
}

/// The will of the connection that is gone comes when the new one is long there.
TEST_F(MemoryBroker, AHalfOpenConnectionHasItsWillLate) {
  auto with_will = options("old");
  with_will.keep_alive = 10s;
  with_will.will = MqttWill{"p/old", "", true, 0};
  connect(ann, with_will);
  ASSERT_TRUE(ann.line->publish({"p/old", "here", true}));
  time.run_for(1s);
  broker.stall("old", true);
  ASSERT_TRUE(ann.line->publish({"lost", "1"}));
  ann.line.reset();
  connect(bob, options("new"));
  ASSERT_TRUE(bob.line->subscribe("p/#"));
  time.run_for(19s);
  EXPECT_THAT(bob.received, ElementsAre("p/old here*"));
  EXPECT_THAT(broker.clients(), ElementsAre("new", "old"));
  time.run_for(1s);
  EXPECT_THAT(bob.received, ElementsAre("p/old here*", "p/old "));
  EXPECT_THAT(broker.clients(), ElementsAre("new"));
  EXPECT_THAT(broker.published("lost"), IsEmpty());
}

TEST_F(MemoryBroker, AHalfOpenLineIsLostAfterTwoKeepAliveTimesOrGoesOn) {
  auto ten = options("ann");
  ten.keep_alive = 10s;
  connect(ann, ten);
  connect(bob, options("bob"));
  ASSERT_TRUE(ann.line->subscribe("a"));
  time.run_for(1s);
  broker.stall("ann", true);
  ASSERT_TRUE(bob.line->publish({"a", "1"}));
  ASSERT_TRUE(ann.line->publish({"b", "2"}));
  time.run_for(9s);
  EXPECT_THAT(ann.received, IsEmpty());
  EXPECT_THAT(broker.published("b"), IsEmpty());
  broker.stall("ann", false);
  time.run_for(1min);
  EXPECT_THAT(ann.received, ElementsAre("a 1"));
  EXPECT_THAT(broker.published("b"), ElementsAre("2"));
  broker.stall("ann", true);
  time.run_for(19s);
  EXPECT_THAT(ann.failures, IsEmpty());
  EXPECT_TRUE(ann.line->publish({"b", "3"}));
  time.run_for(2s);
  ASSERT_THAT(ann.failures, SizeIs(1));
  EXPECT_THAT(ann.failures[0].text, HasSubstr("does not answer"));
  EXPECT_THAT(broker.clients(), ElementsAre("bob"));
}

TEST_F(MemoryBroker, ASlowReaderLosesTheNewest) {
  broker.max_queued = 3;
  broker.max_in_flight = 2;
  connect(ann, options("ann"));
  connect(bob, options("bob"));
  for (const auto* filter : {"a", "b"}) ASSERT_TRUE(ann.line->subscribe(filter, *filter == 'b' ? 1 : 0));
  time.run_for(1s);
  broker.slow("ann", 1s);
  for (int i = 0; i < 9; ++i) ASSERT_TRUE(bob.line->publish({"a", std::to_string(i), false, 1}));
  time.run_for(10s);
  EXPECT_THAT(ann.received, ElementsAre("a 0", "a 1", "a 2", "a 3"));
  EXPECT_THAT(bob.taken, SizeIs(9));
  ann.received.clear();
  for (int i = 0; i < 9; ++i) ASSERT_TRUE(bob.line->publish({"b", std::to_string(i), false, 1}));
  time.run_for(4s);
  EXPECT_THAT(ann.received, SizeIs(4)) << "one a second";
  time.run_for(10s);
  EXPECT_THAT(ann.received, ElementsAre("b 0", "b 1", "b 2", "b 3", "b 4"));
}

TEST_F(MemoryBroker, WhatWaitsExpiresAtQos1Only) {
  connect(ann, options("ann"));
  connect(bob, options("bob"));
  ASSERT_TRUE(ann.line->subscribe("a", 1));
  time.run_for(1s);
  broker.stall("ann", true);
  for (const auto qos : {std::uint8_t{0}, std::uint8_t{1}})
    ASSERT_TRUE(bob.line->publish({"a", std::to_string(qos), false, qos, MqttQueue::kInOrder, 2s}));
  time.run_for(3s);
  broker.stall("ann", false);
  time.run_for(1s);
  EXPECT_THAT(ann.received, ElementsAre("a 0"));
}

TEST_F(MemoryBroker, WhatIsRetainedBy311DoesNotExpire) {
  auto old = options();
  old.version = MqttVersion::k311;
  connect(ann, old);
  ASSERT_TRUE(ann.line->publish({"a", "1", true, 0, MqttQueue::kInOrder, 1s}));
  broker.publish("b", "1", true, 0, 1s);
  broker.publish("c", "1", true, 0, 1s);
  broker.publish("c", "2", true);
  time.run_for(2s);
  EXPECT_THAT(broker.retained(), ElementsAre(std::pair("a", "1"), std::pair("c", "2")));
}

TEST_F(MemoryBroker, LosesWhatATestWants) {
  broker.loses = [](const std::string& client, const MqttPublication& message) {
    return client == "ann" && message.payload == "2";
  };
  connect(ann, options("ann"));
  connect(bob, options("bob"));
  for (auto* client : {&ann, &bob}) ASSERT_TRUE(client->line->subscribe("a"));
  for (const auto* payload : {"1", "2", "3"}) ASSERT_TRUE(bob.line->publish({"a", payload}));
  time.run_for(1s);
  EXPECT_THAT(ann.received, ElementsAre("a 1", "a 3"));
  EXPECT_THAT(bob.received, SizeIs(3));
}

TEST_F(MemoryBroker, DropsWhatAnAccessListForbidsAndRepeatsQos1WhereATestWants) {
  broker.ignored_topics = {"forbidden/#"};
  broker.repeats = true;
  connect(ann, options());
  ASSERT_TRUE(ann.line->subscribe("#", 1));
  ASSERT_TRUE(ann.line->publish({"forbidden/a", "1"}));
  ASSERT_TRUE(ann.line->publish({"b", "2", false, 1}));
  time.run_for(1s);
  EXPECT_THAT(ann.received, ElementsAre("b 2", "b 2"));
}

TEST_F(MemoryBroker, ALineMayBeDestroyedInEachOfItsCalls) {
  broker.publish("a", "1", true);
  for (const auto* in : {"connected", "received", "refused", "failed"}) {
    std::unique_ptr<MqttLine> line;
    int calls_after = 0;
    const auto end = [&](std::string_view call) {
      if (line == nullptr) ++calls_after;
      if (call == in) line.reset();
    };
    MqttCallbacks calls;
    calls.connected = [&](const auto&) { end("connected"); };
    calls.received = [&](const auto&) { end("received"); };
    calls.refused = [&](auto, const auto&) { end("refused"); };
    calls.failed = [&](const auto&) { end("failed"); };
    broker.refused_filters = {"b"};
    line = *memory.open_mqtt(options(), calls);
    ASSERT_TRUE(line->subscribe("b"));
    ASSERT_TRUE(line->subscribe("a"));
    time.run_for(1s);
    broker.cut();
    time.run_for(1s);
    EXPECT_EQ(line, nullptr) << in;
    EXPECT_EQ(calls_after, 0) << in;
  }
}

TEST_F(MemoryBroker, WrongOptionsTopicsAndFiltersAreRefused) {
  auto wrong = options("not-a-legal-id");
  EXPECT_EQ(memory.open_mqtt(wrong, {}).error().code, ErrorCode::kInvalid);
  wrong = options();
  wrong.password = "x";
  EXPECT_THAT(memory.open_mqtt(wrong, {}).error().text, HasSubstr("a password needs a user"));
  wrong = options();
  wrong.keep_alive = 4s;
  EXPECT_THAT(memory.open_mqtt(wrong, {}).error().text, HasSubstr("keep-alive must be 5 s to"));
  wrong.keep_alive = 5s;
  wrong.will = MqttWill{"a", "", true, 2};
  EXPECT_THAT(memory.open_mqtt(wrong, {}).error().text, HasSubstr("QoS of the will"));
  connect(ann, options());
  EXPECT_EQ(ann.line->publish({"a/+", ""}).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(ann.line->subscribe("a/#/b").error().code, ErrorCode::kInvalid);
  EXPECT_EQ(ann.line->subscribe("a", 2).error().code, ErrorCode::kInvalid);
}

TEST(MqttTopics, HaveAtMost200Levels) {
  std::string levels(199, '/');
  EXPECT_TRUE(is_mqtt_topic(levels));
  EXPECT_TRUE(is_mqtt_filter(levels));
  levels += '/';
  EXPECT_FALSE(is_mqtt_topic(levels));
  EXPECT_FALSE(is_mqtt_filter(levels));
}

TEST(MqttCounters, OfSeveralLinesAreAdded) {
  MqttCounters sum{1, 2, 3, 4};
  sum += {10, 20, 30, 40};
  EXPECT_EQ(sum.received, 11U);
  EXPECT_EQ(sum.sent, 22U);
  EXPECT_EQ(sum.too_long, 33U);
  EXPECT_EQ(sum.not_taken, 44U);
}

TEST(MqttTopics, MatchAsTheStandardSays) {
  for (const auto* right : {"#", "+", "a/b", "+/b/#", "/", "a//b", "$SYS/#"})
    EXPECT_TRUE(is_mqtt_filter(right)) << right;
  for (const auto* right : {"\xc2\xa0", "\xef\xb7\xb0", "\xef\xbf\xbd", "\xf0\x9f\xbf\xbd"})
    EXPECT_TRUE(is_mqtt_topic(right));
  for (const auto* wrong : {"", "a#", "#/a", "a+/b", "\xff", "a\x7f", "a\xc2\x85", "\xc2\x9f", "\t", "\xef\xb7\xaf",
                            "\xef\xbf\xbe", "\xf0\x9f\xbf\xbf"})
    EXPECT_FALSE(is_mqtt_filter(wrong)) << wrong;
  EXPECT_FALSE(is_mqtt_topic("a/+"));
  EXPECT_FALSE(is_mqtt_topic(std::string_view("a\0b", 3)));
  EXPECT_FALSE(is_mqtt_topic(std::string(65536, 'a')));
  const auto matches = [](std::string_view filter, std::string_view topic) { return mqtt_matches(filter, topic); };
  EXPECT_TRUE(matches("a/#", "a"));
  EXPECT_TRUE(matches("a/#", "a/b/c"));
  EXPECT_TRUE(matches("+/+", "/a"));
  EXPECT_TRUE(matches("/+", "/a"));
  EXPECT_TRUE(matches("a/+", "a/"));
  EXPECT_FALSE(matches("+", "/a"));
  EXPECT_FALSE(matches("a/+", "a"));
  EXPECT_FALSE(matches("a/b", "a/b/c"));
  EXPECT_FALSE(matches("a/b/c", "a/b"));
  EXPECT_FALSE(matches("#", "$SYS/uptime"));
  EXPECT_TRUE(matches("$SYS/#", "$SYS/uptime"));
}

TEST(MqttOutQueue, TheLatestStateTakesThePlaceOfTheOneThatWaits) {
  MqttOutQueue queue;
  const auto push = [&](const char* topic, const char* payload, MqttQueue kind) {
    ASSERT_TRUE(queue.push({topic, payload, false, 0, kind}, "line"));
  };
  push("a", "1", MqttQueue::kLatest);
  push("b", "1", MqttQueue::kInOrder);
  push("a", "2", MqttQueue::kLatest);
  push("b", "2", MqttQueue::kInOrder);
  push("a", "3", MqttQueue::kInOrder);
  push("a", "4", MqttQueue::kLatest);
  std::string all;
  while (const auto next = queue.pop()) all += next->topic + next->payload + ' ';
  EXPECT_EQ(all, "a2 b1 b2 a3 a4 ");
  EXPECT_EQ(queue.bytes(), 0U);
  for (std::size_t i = 0; i < MqttLine::kMaxQueued; ++i) push("a", "", MqttQueue::kInOrder);
  EXPECT_EQ(queue.push({"a", "", false, 0, MqttQueue::kLatest}, "line").error().code, ErrorCode::kBusy);
}

TEST(MqttOutQueue, WhatLeavesTogetherKeepsItsOrder) {
  MqttOutQueue queue;
  const auto push = [&](const std::string& payload, std::uint8_t qos) {
    ASSERT_TRUE(queue.push({"a", payload, false, qos}, "line"));
  };
  const auto take = [&](std::size_t most_of_qos_1) {
    std::vector<MqttPublication> taken;
    queue.take(most_of_qos_1, taken);
    std::string all;
    for (const auto& one : taken) all += one.payload.front();
    return all;
  };
  for (const auto* one : {"a0", "b0", "c1", "d1", "e1", "f0"}) push({one[0]}, static_cast<std::uint8_t>(one[1] - '0'));
  EXPECT_EQ(take(0), "ab") << "QoS 1 waits for answers";
  EXPECT_EQ(take(2), "cd");
  EXPECT_EQ(take(0), "");
  EXPECT_EQ(take(5), "e") << "QoS 0 is written by another";
  EXPECT_EQ(take(0), "f");
  for (int i = 0; i < 5; ++i) push(std::string(40'000, 'x'), 0);
  EXPECT_EQ(take(0), "xx") << "so much is enough for one write";
  EXPECT_EQ(queue.size(), 3U);
}

}  // namespace
}  // namespace rubicon::transport
