#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/virtual_scheduler.h"
#include "rubicon/tuple_space.hpp"
#include "support/collecting_log.h"
#include "support/memory/memory_transports.h"
#include "support/memory/mqtt_broker.h"
#include "support/rights.h"
#include "tuples/component.h"
#include "tuples/distant/frame_codec.h"
#include "tuples/mqtt/mqtt_ecology.h"
#include "tuples/mqtt/written_realm.h"
#include "tuples/peer_policy.h"

namespace rubicon::tuples::mqtt {
namespace {

using namespace std::chrono_literals;
using testing::AnyOf;
using testing::ElementsAre;
using testing::IsEmpty;

const transport::Endpoint kRealmBroker{"10.0.0.1", 1883};
constexpr OwnerId kHallIsland{1}, kLabIsland{2}, kDesk{70000}, kGuest{70001};
const std::string kRoot = "rubicon-space/1/default/";
constexpr std::uint64_t kRogueStart = 1'000'000'000'000'000;  // 2001
const std::string kShown = "rubicon-space/1/default/p/realm/";

/// A member at its own site.
struct MemberSite {
  MemberSite(VirtualScheduler& scheduler, transport::MemoryNet& net, const std::string& user, OwnerId id,
             const std::string& address, const std::string& first)
      : time(scheduler), realm(std::make_shared<WrittenRealm>(first)) {
    machine.join(net, address);
    SpaceOptions options;
    auto& at = options.brokers.emplace_back();
    at.line.host = kRealmBroker.address;
    at.line.port = kRealmBroker.port;
    at.line.user = at.user = user;
    at.line.password = "secret";
    options.watch_all = true;
    options.judge = std::make_shared<rights::RightsJudge>(rights::Rights());
    options.realm = realm;
    ecology =
        std::move(*MqttEcology::open(options, time, machine, log, [this] { return time.now().time_since_epoch(); }));
    link = std::move(*ecology->join(id));
    space = std::make_unique<TupleSpace>(id, time, *link);
    changes = realm->watch([this] { SpaceRights::rejudge(*space); });
    peers = space->watch_peers([this](OwnerId peer, PeerEvent event) {
      events.push_back((event == PeerEvent::kUp ? "up " : "down ") + std::to_string(number(peer)));
    });
  }
  std::vector<std::string> take() { return std::exchange(events, {}); }

  VirtualScheduler& time;
  std::shared_ptr<WrittenRealm> realm;
  transport::MemoryTransports machine;
  support::CollectingLog log;
  std::unique_ptr<MqttEcology> ecology;
  std::unique_ptr<Link> link;
  std::unique_ptr<TupleSpace> space;
  std::vector<std::string> events;
  Handle peers, changes;
};

/// The owner of a lamp (hall), another island (lab), and two people who look at the lamp: one of them is shut out.
struct RealmAtABroker : testing::Test {
  RealmAtABroker() {
    broker.rights = transport::MqttRights{{"rubicon-space/1/+/p/#", "rubicon-space/1/+/to/%u/#"},
                                          {"rubicon-space/1/+/p/+/%u/#", "rubicon-space/1/+/to/+/+/%u/+"}};
    for (const auto* user : {"hall", "lab", "desk", "guest", "new"}) broker.users[user] = "secret";
    hall = member("hall", kHallIsland, "10.0.0.2");
    lab = member("lab", kLabIsland, "10.0.0.3");
    desk = member("desk", kDesk, "10.0.0.4");
    guest = member("guest", kGuest, "10.0.0.5");
    open = hall->space->add_policy(pattern("lamp"), [this](const RemoteSet& set) {
      decided.push_back(set.value);
      return SetDecision::applied();
    });
    EXPECT_TRUE(hall->space->set("lamp", "off"));
    of_desk = desk->space->subscribe(pattern("1:**"), {}, desk_sees.call());
    of_guest = guest->space->subscribe(pattern("1:**"), {}, guest_sees.call());
    time.run_for(5s);
    EXPECT_THAT(desk_sees.take(), ElementsAre("lamp=off"));
    EXPECT_THAT(guest_sees.take(), ElementsAre("lamp=off"));
    for (auto* one : {&hall, &lab, &desk, &guest}) (*one)->take();
  }
  std::unique_ptr<MemberSite> member(const std::string& user, OwnerId id, const std::string& address,
                                     const std::string& first = kFirst) {
    return std::make_unique<MemberSite>(time, net, user, id, address, first);
  }
  Verdict command(MemberSite& from, const std::string& value) {
    std::optional<Verdict> verdict;
    from.space->set_remote(kHallIsland, "lamp", value, 3s, [&](const Reply& reply) { verdict = reply.verdict; });
    time.run_for(4s);
    return verdict.value_or(Verdict::kTimedOut);
  }
  /// Whether hall takes nothing of the guest, and gives it nothing; desk is as before, and lab noticed nothing.
  void expect_shut_out(const std::string& value) {
    decided.clear();
    guest_sees.take();
    EXPECT_TRUE(hall->space->set("lamp", value));
    EXPECT_NE(command(*guest, "stolen"), Verdict::kApplied);
    EXPECT_THAT(guest_sees.take(), IsEmpty()) << "it receives nothing more";
    EXPECT_EQ(command(*desk, "bright"), Verdict::kApplied);
    EXPECT_THAT(decided, ElementsAre("bright"));
    EXPECT_THAT(desk_sees.take(), testing::Contains("lamp=" + value));
    for (const auto* one : {&hall, &lab, &desk}) {
      EXPECT_THAT((*one)->space->peers(), testing::Not(testing::Contains(kGuest)));
      for (const auto& event : (*one)->take())
        EXPECT_THAT(event, AnyOf("down 70001", "up 70009")) << "nobody else is lost or met";
    }
  }
  /// A component that is earlier than each real one, and answers all who ask whether it lives.
  std::unique_ptr<transport::MqttLine> rogue(OwnerId id) {
    transport::MqttOptions options;
    options.host = kRealmBroker.address;
    options.user = "guest";
    options.password = "secret";
    transport::MqttCallbacks calls;
    calls.connected = [](const transport::MqttConnack&) {};
    calls.received = [this](const transport::MqttMessage& message) { answer(message); };
    calls.failed = [](const Error&) {};
    other_machine.join(net, "10.0.0.9");
    auto line = std::move(*other_machine.open_mqtt(options, calls));
    time.run_for(1s);
    EXPECT_TRUE(line->subscribe(kRoot + "to/guest/00000000000a/#", 0));
    const std::string at = kRoot + "p/a/guest/00000000000a";
    EXPECT_TRUE(line->publish({at, line_text({1, 20s}), true, 1, {}, {}, 0}));
    const auto shown = component_text({kRogueStart, "far", {}});
    EXPECT_TRUE(line->publish({at + "/" + std::to_string(number(id)), shown, true, 1, {}, {}, 0}));
    return line;
  }
  void answer(const transport::MqttMessage& message) {
    ByteView entries;
    const auto head = read_head(base::as_bytes(message.payload), entries);
    if (!head || entries.empty() || head->number != 0) return;
    ++questions;
    struct Asked final : distant::FrameReader {
      void on_identity_check(const distant::IdentityCheck& check) override { number = check.number; }
      std::uint64_t number = 0;
    } asked;
    EXPECT_TRUE(distant::read_frame(entries, head->source, head->target, asked));
    send_answer(*head, asked.number, std::string(message.topic));
  }
  /// To where it came from.
  void send_answer(const FrameHead& question, std::uint64_t number, const std::string& topic) {
    FrameHead back;
    back.source = question.target;
    back.source_incarnation = question.target_incarnation;
    back.target = question.source;
    back.target_incarnation = question.source_incarnation;
    distant::FrameWriter entry;
    entry.add(distant::IdentityCheck{true, number});
    const auto asker = topic.substr((kRoot + "to/guest/00000000000a/").size());
    broker.publish(kRoot + "to/" + asker + "/guest/00000000000a", base::as_text(frame_of(back, entry.view())));
  }
  std::vector<std::string> shown() const {
    std::vector<std::string> all;
    for (const auto& [topic, text] : broker.retained()) {
      if (topic.starts_with(kShown)) all.push_back(topic.substr(kShown.size()) + " " + text);
    }
    return all;
  }
  std::unique_ptr<transport::MqttLine> by_hand(const std::string& user) {
    transport::MqttOptions options;
    options.host = kRealmBroker.address;
    options.user = user;
    options.password = "secret";
    transport::MqttCallbacks calls;
    calls.connected = [](const transport::MqttConnack&) {};
    calls.received = [](const transport::MqttMessage&) {};
    calls.failed = [](const Error&) {};
    other_machine.join(net, "10.0.0.9");
    auto line = std::move(*other_machine.open_mqtt(options, calls));
    time.run_for(1s);
    return line;
  }

  int questions = 0;
  static inline const std::string kFirst = document(1, "hall:1 lab:2 desk:admin guest:admin");
  static inline const std::string kShutOut = document(2, "hall:1 lab:2 desk:admin");

  VirtualScheduler time;
  transport::MemoryNet net{time};
  transport::MqttBroker broker{net, kRealmBroker};
  transport::MemoryTransports other_machine;
  std::vector<std::string> decided;
  Listener desk_sees, guest_sees;
  std::unique_ptr<MemberSite> hall, lab, desk, guest;
  Handle open, of_desk, of_guest;
};

TEST_F(RealmAtABroker, WhoIsShutOutWhileItLooksIsOutAtOnceAtAllMembers) {
  lab->realm->found(kShutOut);
  time.run_for(100ms);
  for (const auto* one : {&hall, &lab, &desk}) EXPECT_THAT((*one)->events, ElementsAre("down 70001"));
  expect_shut_out("dim");
}

TEST_F(RealmAtABroker, WhoIsShutOutWhileItSleptIsOutWhenItIsBack) {
  std::string client;
  for (const auto& one : broker.published()) {
    if (one.topic.find("/guest/") != one.topic.npos && one.retain) client = one.client;
  }
  broker.stall(client, true);
  time.run_for(1s);
  hall->realm->found(kShutOut);
  time.run_for(1min);
  broker.stall(client, false);
  time.run_for(30s);
  EXPECT_GT(guest->ecology->counters().reconnects, 0U);
  expect_shut_out("dim");
}

TEST_F(RealmAtABroker, WhoIsShutOutWhileTheBrokerWasDownIsOutWhenItIsBack) {
  for (const bool retained : {true, false}) {
    broker.stop(retained);
    time.run_for(1s);
    if (retained) lab->realm->found(kShutOut);
    time.run_for(2s);
    broker.start();
    time.run_for(40s);
    expect_shut_out(retained ? "dim" : "bright");
  }
}

/// A member that slept while another one was shut out hears of it before anything of that one.
TEST_F(RealmAtABroker, AMemberThatSleptTakesNothingOfWhoWasShutOutMeanwhile) {
  open.reset();
  hall->peers.reset();
  hall->space.reset();
  hall->link.reset();
  hall.reset();
  lab->realm->found(kShutOut);
  time.run_for(5s);
  const auto eager = guest->space->watch_peers([this](OwnerId peer, PeerEvent event) {
    if (peer == kHallIsland && event == PeerEvent::kUp)
      guest->space->set_remote(kHallIsland, "lamp", "stolen", 3s, [](const Reply&) {});
  });
  hall = member("hall", kHallIsland, "10.0.0.7");  // with the document of before
  open = hall->space->add_policy(pattern("lamp"), [this](const RemoteSet& set) {
    decided.push_back(set.value);
    return SetDecision::applied();
  });
  time.run_for(5s);
  EXPECT_EQ(hall->realm->document(), kShutOut);
  EXPECT_THAT(guest->take(), testing::Contains("up 1"));
  EXPECT_THAT(decided, IsEmpty());
  for (auto* one : {&hall, &lab, &desk}) (*one)->take();
  expect_shut_out("dim");
}

/// Frames of members that nobody knows yet are kept a moment.
TEST_F(RealmAtABroker, FramesOfWhoWasShutOutAreNotKept) {
  const auto line = by_hand("guest");
  std::string inbox;
  for (const auto& [topic, payload] : broker.retained()) {
    if (topic.ends_with("/1")) inbox = "rubicon-space/1/default/to/hall/" + topic.substr(topic.size() - 14, 12);
  }
  FrameHead head;
  head.source = OwnerId(70009);
  head.target = kHallIsland;
  for (const auto& [topic, payload] : broker.retained()) {
    if (topic.ends_with("/1")) head.target_incarnation = read_component(payload)->incarnation;
  }
  head.stream = head.number = head.first = 1;
  const auto frame = frame_of(head, {});
  const auto send = [&] {
    EXPECT_TRUE(line->publish({inbox + "/guest/00000000000f", std::string(base::as_text(frame)), false, 0, {}, {}, 0}));
    time.run_for(1s);
    return hall->ecology->counters().foreign;
  };
  const auto before = send();
  EXPECT_EQ(send(), before);
  hall->realm->found(kShutOut);
  EXPECT_EQ(send(), before + 1);
}

TEST_F(RealmAtABroker, ANewRoleCountsAtOnceAndNobodyIsLost) {
  hall->realm->found(document(2, "hall:1 lab:2 desk:admin guest"));
  EXPECT_TRUE(hall->space->set("lamp", "dim"));
  time.run_for(1s);
  EXPECT_THAT(guest_sees.take(), testing::Each(testing::Not("lamp=dim")));
  EXPECT_EQ(command(*guest, "stolen"), Verdict::kRefused);
  EXPECT_THAT(decided, IsEmpty());
  lab->realm->found(document(3, "hall:1 lab:2 desk guest:admin"));
  time.run_for(1s);
  EXPECT_THAT(guest_sees.take(), ElementsAre("lamp=dim"));
  EXPECT_EQ(command(*guest, "on"), Verdict::kApplied);
  EXPECT_EQ(command(*desk, "off"), Verdict::kRefused);
  for (const auto* one : {&hall, &lab, &desk, &guest}) EXPECT_THAT((*one)->events, IsEmpty());
}

/// Its presence came first.
TEST_F(RealmAtABroker, AMemberIsMetWhenTheDocumentNamesIt) {
  const auto later = member("new", OwnerId{3}, "10.0.0.6");
  time.run_for(5s);
  EXPECT_THAT(hall->take(), IsEmpty());
  lab->realm->found(document(2, "hall:1 lab:2 desk:admin guest:admin new:3"));
  time.run_for(1s);
  EXPECT_THAT(hall->take(), ElementsAre("up 3"));
  EXPECT_EQ(later->realm->document(), lab->realm->document());
}

/// A tool that runs for a moment.
TEST_F(RealmAtABroker, WhoStartsWithANewerOneShowsItAtOnce) {
  const auto tool = member("desk", OwnerId{70009}, "10.0.0.6", kShutOut);
  time.run_for(50ms);
  EXPECT_EQ(hall->realm->document(), kShutOut);
  time.run_for(1s);
  expect_shut_out("dim");
}

TEST_F(RealmAtABroker, OneShowsTheNewestAndOthersTakeTheirsAway) {
  EXPECT_THAT(shown(), ElementsAre("desk " + kFirst)) << "all began at once, and one is enough";
  lab->realm->found(kShutOut);
  time.run_for(1s);
  EXPECT_THAT(shown(), ElementsAre("lab " + kShutOut));
  broker.publish(kShown + "desk", kShutOut, true);
  broker.publish(kShown + "aaa", kShutOut, true);
  time.run_for(1s);
  EXPECT_THAT(shown(), ElementsAre("aaa " + kShutOut, "desk " + kShutOut)) << "who is not a member is not enough";
  for (const auto* one : {&hall, &desk, &guest}) EXPECT_EQ((*one)->realm->document(), kShutOut);
  broker.restart({});
  time.run_for(1min);
  EXPECT_GE(shown().size(), 1U) << "what the broker lost is shown again";
  for (const auto& one : shown()) EXPECT_THAT(one, testing::HasSubstr(kShutOut));
  broker.restart({{kShown + "desk", kFirst}});
  time.run_for(1min);
  EXPECT_THAT(shown(), testing::Not(testing::Contains("desk " + kFirst))) << "its own old one is taken away";
}

TEST_F(RealmAtABroker, WhatIsWrongOldOrTooLongIsDroppedAndCounted) {
  hall->realm->found(kShutOut);
  time.run_for(1s);
  const auto before = lab->ecology->documents();
  const auto line = by_hand("guest");
  const auto show = [&](const std::string& text) {
    EXPECT_TRUE(line->publish({kShown + "guest", text, true, 1, {}, {}, 0}));
    time.run_for(3s);
  };
  show("forged 9 guest:admin");
  EXPECT_EQ(lab->ecology->documents().refused, before.refused + 1);
  show(std::string(UserRealm::kMaxDocument + 1, 'x'));
  EXPECT_EQ(lab->ecology->documents().refused, before.refused + 2);
  EXPECT_TRUE(lab->log.contains("the realm file that user guest shows is ignored: it is not signed by the authority"));
  show(kFirst);
  EXPECT_EQ(lab->ecology->documents().old, before.old + 1);
  EXPECT_EQ(lab->realm->document(), kShutOut);
  expect_shut_out("dim");
}

TEST_F(RealmAtABroker, AFloodOfOneUserIsLimitedAndItsLastOneCounts) {
  const auto line = by_hand("guest");
  const auto before = lab->realm->taken;
  for (int i = 0; i < 200; ++i)
    EXPECT_TRUE(line->publish({kShown + "guest", "forged " + std::to_string(i), true, 1, {}, {}, 0}));
  EXPECT_TRUE(line->publish({kShown + "guest", kShutOut, true, 1, {}, {}, 0}));
  time.run_for(1s);
  EXPECT_LE(lab->realm->taken - before, 1);
  time.run_for(4s);
  EXPECT_LE(lab->realm->taken - before, 2);
  EXPECT_EQ(lab->realm->document(), kShutOut) << "whoever shows it";
  expect_shut_out("dim");
}

TEST_F(RealmAtABroker, WhoMakesUpUsersMakesNoMemberWait) {
  broker.rights.reset();
  const auto line = by_hand("guest");
  const auto before = lab->realm->taken;
  for (int i = 0; i < 400; ++i)
    EXPECT_TRUE(
        line->publish({kShown + "u" + std::to_string(i), "forged" + std::string(20'000, 'x'), true, 0, {}, {}, 0}));
  time.run_for(500ms);
  EXPECT_LE(lab->realm->taken - before, static_cast<int>(Documents::kMaxChecks));
  EXPECT_GE(lab->ecology->documents().refused, 300U);
  lab->realm->found(kShutOut);
  time.run_for(1s);
  expect_shut_out("dim");
}

TEST_F(RealmAtABroker, OfUsersWhoAreNoMembersNotMoreAreLookedAtThanThereMayBe) {
  for (std::size_t i = 0; i < Documents::kMaxUsers; ++i) {
    broker.publish(kShown + "u" + std::to_string(i), "forged", true);
    if (i % 500 == 0) time.run_for(10ms);
  }
  time.run_for(1s);
  broker.publish(kShown + "new", document(2, "hall:1 lab:2 desk:admin new:3"), true);
  time.run_for(1s);
  EXPECT_EQ(lab->realm->document(), kFirst) << "there are too many users";
  hall->realm->found(kShutOut);
  time.run_for(1s);
  expect_shut_out("dim");
}

/// Each member may use the ids of tools.
TEST_F(RealmAtABroker, NobodyEndsAComponentOfAnotherUser) {
  std::vector<OwnerId> displaced;
  desk->ecology->watch_displaced([&](OwnerId id) { displaced.push_back(id); });
  const auto line = rogue(kDesk);
  time.run_for(1min);
  EXPECT_THAT(displaced, IsEmpty());
  EXPECT_EQ(command(*desk, "on"), Verdict::kApplied);
  EXPECT_TRUE(desk->log.contains("user guest shows a component 70000, too"));
}

/// It does not acknowledge, so it is asked; the number of that question ends nobody else.
TEST_F(RealmAtABroker, NobodyAnswersForAnother) {
  std::vector<OwnerId> displaced;
  hall->ecology->watch_displaced([&](OwnerId id) { displaced.push_back(id); });
  const auto line = rogue(OwnerId(70009));
  const auto all = hall->space->subscribe(pattern("*:x"), {}, [](const Event&) {});
  time.run_for(1min);
  EXPECT_GT(questions, 0);
  EXPECT_THAT(hall->space->peers(), testing::Contains(OwnerId(70009))) << "it answers: it is there";
  for (const auto& [topic, payload] : std::map(broker.retained())) {
    if (!topic.starts_with(kRoot + "p/") || !topic.ends_with("/1")) continue;
    FrameHead question;
    question.source = question.target = kHallIsland;
    question.source_incarnation = read_component(payload)->incarnation;
    question.target_incarnation = kRogueStart;
    const auto at = topic.substr(kRoot.size() + 4, topic.size() - kRoot.size() - 6);
    for (std::uint64_t number = 0; number < 3; ++number)
      send_answer(question, number, kRoot + "to/guest/00000000000a/" + at);
  }
  time.run_for(10s);
  EXPECT_THAT(displaced, IsEmpty());
}

/// The inboxes are protected.
TEST_F(RealmAtABroker, WhereAllMayWriteThePresenceOfOthersRolesCountForNothing) {
  broker.stop(true);
  broker.rights->write.front() = "rubicon-space/1/+/p/#";
  broker.start();
  time.run_for(10s);
  EXPECT_NE(command(*desk, "off"), Verdict::kApplied);
  EXPECT_TRUE(hall->log.contains("lets users write in each other's names"));
}

TEST_F(RealmAtABroker, WithoutRightsAtTheBrokerRolesCountForNothing) {
  EXPECT_EQ(command(*desk, "on"), Verdict::kApplied);
  broker.stop(true);
  broker.rights.reset();
  broker.start();
  time.run_for(10s);
  EXPECT_NE(command(*desk, "off"), Verdict::kApplied) << "anybody may have written it";
  EXPECT_TRUE(hall->log.contains("lets users write in each other's names"));
  broker.stop(true);
  broker.rights = transport::MqttRights{{"rubicon-space/1/+/p/#", "rubicon-space/1/+/to/%u/#"},
                                        {"rubicon-space/1/+/p/+/%u/#", "rubicon-space/1/+/to/+/+/%u/+"}};
  broker.start();
  time.run_for(10s);
  EXPECT_EQ(command(*desk, "dim"), Verdict::kApplied);
  EXPECT_THAT(decided, ElementsAre("on", "dim"));
}

}  // namespace
}  // namespace rubicon::tuples::mqtt
