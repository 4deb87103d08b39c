#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "networks/knx/line/router.h"

namespace rubicon::networks::knx::line {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::SizeIs;

constexpr std::string_view kPlainWrite = "0610053000132900bcd011c80a070300800c33";
/// The group has 100 ms + 3.2 times the latency tolerance to answer.
constexpr Duration kSynchronising = 6500ms;

RoutingOptions secure_options(std::uint8_t key = 7, std::uint16_t address = 0xfffa) {
  RoutingOptions options;
  options.address = wire::IndividualAddress(address);
  options.secure = secure::RoutingKeys{secure::Key(Bytes(16, key)), 2s};
  return options;
}

class SecureRouting : public RoutingOverMemory {
 protected:
  void open(Router& router) {
    ASSERT_TRUE(router.line->open());
    time.run_for(kSynchronising + 1ms);
    ASSERT_EQ(router.line->state().phase, LineState::Phase::kUp);
  }
  Host third{net, "10.77.0.4"};
};

TEST_F(SecureRouting, TelegramsAreReadByMembersAndByNobodyElse) {
  Router ann(time, here, secure_options()), bob(time, third, secure_options());
  open(ann);
  open(bob);
  other.received.clear();
  ann.send(write_to(0x0a07));
  time.run_for(1s);
  EXPECT_THAT(ann.outcomes, ElementsAre(SendOutcome::kSent));
  ASSERT_THAT(bob.received, SizeIs(1));
  EXPECT_EQ(bob.received[0].payload.bytes, (Bytes{0x0c, 0x33}));
  EXPECT_THAT(ann.received, IsEmpty()) << "multicast brings our own back";
  ASSERT_THAT(other.received, SizeIs(1));
  EXPECT_TRUE(other.received[0].second.starts_with("06100950")) << other.received[0].second;
  EXPECT_EQ(bob.line->counters().at("secure-received"), 1u);
}

TEST_F(SecureRouting, ALineIsUpWhenItHasTheTimerOfItsGroup) {
  Router ann(time, here, secure_options());
  ann.send(write_to(0x0a07), 1min);
  ASSERT_TRUE(ann.line->open());
  time.run_for(kSynchronising - 1ms);
  EXPECT_EQ(ann.states.back().phase, LineState::Phase::kConnecting);
  EXPECT_THAT(ann.states.back().reason, HasSubstr("timer"));
  EXPECT_THAT(ann.outcomes, IsEmpty());
  time.run_for(1s);
  EXPECT_EQ(ann.states.back().phase, LineState::Phase::kUp);
  EXPECT_THAT(ann.states.back().reason, HasSubstr("no other member"));
  EXPECT_THAT(ann.outcomes, ElementsAre(SendOutcome::kSent));

  Router bob(time, third, secure_options(7, 0xfff9));
  ASSERT_TRUE(bob.line->open());
  time.run_for(1s);
  EXPECT_EQ(bob.states.back().phase, LineState::Phase::kUp) << "a member answers";
  EXPECT_EQ(bob.states.back().reason, "");
  bob.send(write_to(0x0a08));
  time.run_for(1s);
  EXPECT_EQ(ann.states.back().reason, "");
}

TEST_F(SecureRouting, PlainFramesAreDroppedAndSaid) {
  Router ann(time, here, secure_options());
  open(ann);
  from_other(kPlainWrite);
  EXPECT_THAT(ann.received, IsEmpty());
  EXPECT_THAT(ann.frames, IsEmpty());
  EXPECT_EQ(ann.line->counters().at("secure-plain-frames"), 1u);
  EXPECT_THAT(ann.notes, Contains(Pair("secure-plain-frames", HasSubstr("10.77.0.3"))));
  from_other("06100201000e08010a4d00039ca4");
  EXPECT_THAT(ann.searches, SizeIs(1));
}

TEST_F(SecureRouting, SecuredGroupsAreEncryptedInside) {
  using secure::GroupGuard;
  constexpr wire::IndividualAddress kAnn{0xfffa}, kBob{0xfff9};
  secure::GroupKeys keys;
  keys.groups[wire::GroupAddress(0x0a07)] = {secure::Key(Bytes(16, 9)), {kAnn, kBob}};
  std::map<std::string, Bytes> values;
  const secure::GroupStorage storage{[&values](std::string_view name, ByteView value) -> Result<void> {
                                       values[std::string(name)] = Bytes(value.begin(), value.end());
                                       return {};
                                     },
                                     [](std::string_view) { return std::optional<Bytes>(); }};
  GroupGuard of_ann(time, keys, storage, kAnn, {}), of_bob(time, keys, storage, kBob, {});
  auto for_ann = secure_options(7, 0xfffa), for_bob = secure_options(7, 0xfff9);
  for_ann.guard = &of_ann;
  for_bob.guard = &of_bob;
  Router ann(time, here, for_ann), bob(time, third, for_bob);
  open(ann);
  open(bob);
  ann.send(write_to(0x0a07));
  time.run_for(1s);
  ASSERT_THAT(bob.received, SizeIs(1));
  EXPECT_EQ(bob.received[0].payload.bytes, (Bytes{0x0c, 0x33}));
  EXPECT_EQ(bob.line->counters().at("data-secure-received"), 1u);
  EXPECT_EQ(bob.line->counters().at("secure-received"), 1u);
}

TEST_F(SecureRouting, AMemberOfAnotherKeyIsNamedAsSuch) {
  Router ann(time, here, secure_options(7)), eve(time, third, secure_options(8));
  open(ann);
  open(eve);
  eve.send(write_to(0x0a07));
  time.run_for(1s);
  EXPECT_THAT(ann.received, IsEmpty());
  EXPECT_THAT(ann.states.back().reason, HasSubstr("another backbone key"));
  EXPECT_EQ(ann.states.back().phase, LineState::Phase::kUp);
}

TEST_F(SecureRouting, NothingIsSentPlainWhateverHappens) {
  Router ann(time, here, secure_options());
  ann.send(write_to(0x0a07), 10min);
  ASSERT_TRUE(ann.line->open());
  time.run_for(1s);
  ASSERT_TRUE(ann.line->open());  // again, before the group answered
  time.run_for(1min);
  for (const auto& [from, frame] : other.received)
    EXPECT_TRUE(frame.starts_with("06100950") || frame.starts_with("06100955")) << frame;
  EXPECT_THAT(ann.outcomes, ElementsAre(SendOutcome::kSent));
}

TEST_F(SecureRouting, ALineMayEndWhileItsTimerCannotBeStored) {
  bool full = false;
  int notes = 0;
  auto options = secure_options();
  options.interface_address = here.at;
  options.storage.store = [&full](std::string_view, ByteView) -> Result<void> {
    return full ? Result<void>(fail(ErrorCode::kIo, "the disk is full")) : Result<void>();
  };
  LineCallbacks calls;
  calls.note = [&notes](const std::string&, std::string_view) { ++notes; };
  auto line = std::make_unique<RoutingLine>(time, here.lines, options, calls);
  ASSERT_TRUE(line->open());
  time.run_for(kSynchronising + 1ms);
  full = true;
  line.reset();
  time.run_for(1s);
  EXPECT_EQ(notes, 0);
}

/// A line of a group of its own is also in 224.0.23.12, where other installations may be.
TEST_F(SecureRouting, OtherInstallationsOfTheSystemGroupAreNoAlarm) {
  auto own = secure_options(7), neighbours = secure_options(8);
  own.group.address = "224.0.23.77";
  Router ann(time, here, own), neighbour(time, third, neighbours);
  open(ann);
  open(neighbour);
  from_other(kPlainWrite);
  from_other("0610053000");
  neighbour.send(write_to(0x0a07));
  time.run_for(1min);
  const auto counters = ann.line->counters();
  for (const auto* name : {"secure-plain-frames", "secure-wrong-mac", "secure-bad-frames", "secure-notifies-received"})
    EXPECT_EQ(counters.at(name), 0U) << name;
  EXPECT_THAT(ann.notes, IsEmpty());
  EXPECT_THAT(ann.states.back().reason, HasSubstr("no other member"));
  from_other("06100201000e08010a4d00039ca4");
  EXPECT_THAT(ann.searches, SizeIs(1));
}

TEST_F(SecureRouting, ALineWithoutRandomBytesIsNotOpened) {
  auto options = secure_options();
  options.random = [](std::span<std::uint8_t>) -> Result<void> { return fail(ErrorCode::kIo, "no random bytes"); };
  Router ann(time, here, options);
  const auto opened = ann.line->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().text, "no random bytes");
  EXPECT_EQ(net.open_sockets(), 1u) << "the other's";
}

/// A wrapper that comes late by network delay, twice, or before another one.
TEST_F(SecureRouting, DelayedAndRepeatedDatagramsAreJudgedByTheirAge) {
  Router ann(time, here, secure_options()), bob(time, third, secure_options());
  open(ann);
  open(bob);
  other.received.clear();
  ann.send(write_to(0x0a07, {1, 1}));
  ann.send(write_to(0x0a07, {2, 2}));
  time.run_for(100ms);
  ASSERT_THAT(other.received, SizeIs(2));
  const auto second = other.received[1].second;
  ASSERT_THAT(bob.received, SizeIs(2));
  from_other(second);
  EXPECT_THAT(bob.received, SizeIs(2));
  EXPECT_EQ(bob.line->counters().at("secure-replays"), 1u);
  time.run_for(5s);
  from_other(second);
  EXPECT_THAT(bob.received, SizeIs(2));
  EXPECT_EQ(bob.line->counters().at("secure-old"), 1u);
}

}  // namespace
}  // namespace rubicon::networks::knx::line
