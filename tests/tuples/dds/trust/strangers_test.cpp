#include <fmt/format.h>
#include <gmock/gmock.h>

#include <csignal>

#include "tuples/dds/trust/trusted_members.h"

namespace rubicon::tuples::dds {
namespace {

using testing::HasSubstr;

const Person kRoof{"roof", "00000009-00000009", "00000009", 9};
constexpr int kManyLists = 400;
constexpr int kFewChecks = 100;  // one a second: fewer than a minute and a half, where nothing waits for more than one

TEST_F(TrustedMembers, MayBeTwoComponentsOfOneProcess) {
  const auto island = member({"home", "00000007-00000007,00200000-002fffff", "00000007,002?????", 7}, 7);
  ASSERT_TRUE(island->line_with("ready"));
  EXPECT_THAT(ask(*island, "other 8"), HasSubstr("has the ids 00000007, 00200000-002fffff"));
  EXPECT_EQ(ask(*island, fmt::format("other {}", 0x00200001)), "is there");
  const auto tool = desk();
  meet(*island, *tool);
  EXPECT_TRUE(until(*tool, "peer 2097153 home"));
  EXPECT_TRUE(until(*tool, "value 2097153 a.other 5"));
  EXPECT_TRUE(until(*island, "value 2097153 a.other 5")) << "also inside the process";
}

/// Her permissions let her read what is for others; her certificate does not have their ids.
TEST_F(TrustedMembers, SendNothingWhereAnotherMemberReads) {
  const auto island = home();
  ASSERT_TRUE(island->line_with("ready"));
  const auto spy = liar({"mallory", kMallory.ids, "????????", kMallory.serial});
  ASSERT_TRUE(spy->line_with("ready")) << "it has met the island";
  spy->write("spy 00000007.01a00001\n");
  ASSERT_TRUE(spy->line_with("did"));
  island->write("set a 1\n");
  const auto roof = member(kRoof, 9), tool = desk();
  ASSERT_TRUE(until(*roof, "peer 7 home"));
  roof->write("send 7 1\n");
  ASSERT_TRUE(until(*roof, "answered 1")) << "the island has caught up: it does not answer many at once";
  ASSERT_TRUE(until(*tool, "peer 7 home"));
  tool->write("send 7 60000\n");  // one each millisecond: the first replies may go before her reader is matched
  EXPECT_TRUE(until(*island, fmt::format("log mallory (certificate BA) reads what is for component {}", kDeskId)))
      << island->errors();
  EXPECT_EQ(ask(*spy, "frames"), "0");
  island->write("set a 2\n");
  spy->signal(SIGKILL);
  EXPECT_TRUE(until(*tool, "value 7 a 2")) << "what waited is sent when she has gone";
}

TEST_F(TrustedMembers, RefuseWhoWasRevokedBeforeItStarted) {
  const auto island = home(), tool = desk();
  meet(*island, *tool);
  tool->write("revoke 1:BA:signed\n");
  ASSERT_TRUE(until(*island, "revoked 1:BA:signed"));
  const auto thief = member(kMallory, kMalloryId);
  EXPECT_TRUE(until(*island, "log 'mallory' was refused: its certificate is revoked"));
  EXPECT_EQ(ask(*island, "refused"), "1");
  thief->write("send 7 3\n");
  EXPECT_TRUE(until(*thief, "answered 3"));
  EXPECT_EQ(ask(*thief, "replies"), "0 of 3");
  EXPECT_EQ(ask(*island, "peers"), std::to_string(kDeskId));
  EXPECT_EQ(ask(*island, "executed"), "0 doubled 0");
  EXPECT_EQ(ask(*island, "refused"), "1") << "it tried again, but is one peer";
}

/// The island executed one command of the thief; then both sleep, and the roof revokes the thief.
class SleepingMembers : public TrustedMembers {
 protected:
  static void revoke_during_sleep(Process& island, Process& roof, Process& thief) {
    ASSERT_TRUE(until(thief, "peer 7 home"));
    ASSERT_TRUE(until(roof, "peer 7 home"));
    ASSERT_TRUE(until(roof, fmt::format("peer {} mallory", kMalloryId)));
    thief.write("send 7 1\n");
    ASSERT_TRUE(until(thief, "answered 1"));
    island.signal(SIGSTOP);
    thief.signal(SIGSTOP);
    ASSERT_TRUE(until(roof, "alone"));
    roof.write("revoke 1:BA:signed\n");
    ASSERT_TRUE(until(roof, "revoked 1:BA:signed"));
  }
};

/// It sleeps while another is revoked, and hears of it from the first member that it meets.
TEST_F(SleepingMembers, ObeyOnWakingBeforeTheRevokedCommandThem) {
  const auto island = home(), roof = member(kRoof, 9), thief = member(kMallory, kMalloryId);
  ASSERT_NO_FATAL_FAILURE(revoke_during_sleep(*island, *roof, *thief));
  island->signal(SIGCONT);
  ASSERT_TRUE(until(*island, "revoked 1:BA:signed"));
  thief->signal(SIGCONT);
  thief->write("send 7 20\n");
  ASSERT_TRUE(until(*thief, "answered 21"));
  EXPECT_EQ(ask(*thief, "replies"), "1 of 21");
  EXPECT_EQ(ask(*island, "executed"), "1 doubled 0");
  EXPECT_TRUE(until(*island, "peer 9 roof"));
}

/// The revoked one is faster than the list.
TEST_F(SleepingMembers, TakeNoCommandBeforeTheListOnWaking) {
  const auto island = home(), roof = member(kRoof, 9), thief = member(kMallory, kMalloryId);
  ASSERT_NO_FATAL_FAILURE(revoke_during_sleep(*island, *roof, *thief));
  thief->write("send 7 2000\n");
  thief->signal(SIGCONT);
  island->signal(SIGCONT);
  EXPECT_TRUE(until(*island, "revoked 1:BA:signed"));
  ASSERT_TRUE(until(*thief, "answered 2001"));
  EXPECT_EQ(ask(*island, "executed"), "1 doubled 0");
}

TEST_F(TrustedMembers, TakeNoCommandBeforeTheListAfterTheirStart) {
  const auto roof = member(kRoof, 9), thief = member(kMallory, kMalloryId);
  ASSERT_TRUE(until(*roof, fmt::format("peer {} mallory", kMalloryId)));
  roof->write("revoke 1:BA:signed\n");
  ASSERT_TRUE(until(*thief, "alone"));
  thief->write("send 7 3000\n");
  const auto island = home();
  EXPECT_TRUE(until(*island, "revoked 1:BA:signed"));
  ASSERT_TRUE(until(*thief, "answered 3000"));
  EXPECT_EQ(ask(*island, "executed"), "0 doubled 0");
}

TEST_F(TrustedMembers, DoNotCheckAllTheListsThatOneOfThemWrites) {
  const auto island = home(), tool = desk();
  meet(*island, *tool);
  const auto mallory = liar();
  ASSERT_TRUE(mallory->line_with("ready"));
  mallory->write(fmt::format("lists {}\n", kManyLists));
  ASSERT_TRUE(mallory->line_with("did"));
  mallory->write(fmt::format("interest {} 1\n", kDeskId));  // after the lists, in order
  ASSERT_TRUE(until(*island, "log mallory writes a subscription in the name of component"));
  const auto checked = std::stoi("0" + ask(*island, "lists"));
  EXPECT_GT(checked, 0);
  EXPECT_LT(checked, kFewChecks);
  tool->write("revoke 1:BA:signed\n");
  EXPECT_TRUE(until(*island, "revoked 1:BA:signed")) << "others are heard at once";
}

TEST_F(TrustedMembers, TakeNoMemoryFromOthersByWhatTheyWrite) {
  const auto island = home(), tool = desk();
  meet(*island, *tool);
  const auto mallory = liar();
  ASSERT_TRUE(mallory->line_with("ready"));
  const auto write = [&](const std::string& what) {
    mallory->write(what + "\n");
    ASSERT_TRUE(mallory->line_with("did"));
  };
  write("lists 50 60000");
  const auto before = island->resident_kilobytes();
  write("lists 3000 60000");
  write("presences 3000 9000");
  tool->write("send 7 50\n");
  EXPECT_TRUE(until(*tool, "answered 50")) << "it has come to what was written after that";
  EXPECT_LT(island->resident_kilobytes() - before, 40'000) << "of 200 MB";
  EXPECT_EQ(ask(*tool, "replies"), "50 of 50");
}

}  // namespace
}  // namespace rubicon::tuples::dds
