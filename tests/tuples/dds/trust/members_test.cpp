#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <thread>

#include "tuples/dds/trust/trusted_members.h"

namespace rubicon::tuples::dds {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST_F(TrustedMembers, MeetKnowEachOtherAndExchangeTuplesAndCommands) {
  const auto island = home(), tool = desk();
  meet(*island, *tool);
  island->write("set a 1\n");
  EXPECT_TRUE(until(*tool, "value 7 a 1"));
  tool->write("send 7 20\n");
  EXPECT_TRUE(until(*tool, "answered 20"));
  EXPECT_EQ(ask(*tool, "replies"), "20 of 20");
  EXPECT_EQ(ask(*island, "executed"), "20 doubled 0");
}

TEST_F(TrustedMembers, HaveTheIdsOfTheirCertificatesOnly) {
  const auto stranger = member(kDesk, 8);
  EXPECT_THAT(stranger->line_with("error").value_or(""),
              HasSubstr("component 8 (hexadecimal 00000008) cannot take part: the certificate of 'desk' has the ids "
                        "01a00000-01afffff"));
  EXPECT_EQ(stranger->exit_code(), 1);
}

TEST_F(TrustedMembers, EndAtTheirStartIfTheyCannotTakePart) {
  const auto lost = member(kDesk, kDeskId, folder_ / "nowhere");
  EXPECT_THAT(lost->line_with("error").value_or(""), HasSubstr("nowhere/certificate.pem: there is no such file"));
  EXPECT_EQ(lost->exit_code(), 1);
  const auto folder = documents(kHome);
  const auto impostor = member(kDesk, kDeskId, folder);
  EXPECT_THAT(impostor->line_with("error").value_or(""), HasSubstr("cannot be made")) << "with the reason of Cyclone";
  EXPECT_EQ(impostor->exit_code(), 1);
}

TEST_F(TrustedMembers, OfAnotherRealmOrOfNoneAreNotSeen) {
  const auto island = home();
  ASSERT_TRUE(island->line_with("ready"));
  const auto other = member(kDesk, kDeskId, documents(kDesk, Realm()));
  const auto plain = member(kDesk, 70'000, "none");
  ASSERT_TRUE(plain->line_with("ready"));
  EXPECT_TRUE(until(*other, "log failed: Certificate not valid")) << "the handshake was refused";
  const auto tool = member(Person{"roof", "00000009-00000009", "00000009", 9}, 9);
  EXPECT_TRUE(until(*tool, "peer 7 home")) << "who came last is seen";
  EXPECT_TRUE(until(*island, "peer 9 roof"));
  EXPECT_EQ(ask(*island, "peers"), "9");
  EXPECT_EQ(ask(*tool, "peers"), "7");
  EXPECT_TRUE(until(*plain, "alone"));
  EXPECT_TRUE(until(*other, "alone"));
}

/// A certificate of her own, and the names of others.
TEST_F(TrustedMembers, CannotBeTakenForOthers) {
  const auto island = home(), tool = desk();
  meet(*island, *tool);
  island->write("set a 1\n");
  ASSERT_TRUE(until(*tool, "value 7 a 1"));
  const auto started = ask(*tool, "incarnation 7"), tools = ask(*island, fmt::format("incarnation {}", kDeskId));
  const auto mallory = liar();
  ASSERT_TRUE(mallory->line_with("ready"));
  const auto tell = [&](const std::string& what) {
    mallory->write(what + "\n");
    EXPECT_TRUE(mallory->line_with("did"));
  };
  tell("presence 7 " + started);
  tell("dispose 7 " + started);
  tell("presence 7 1700000000000000");
  EXPECT_TRUE(until(*tool, "log mallory writes a presence in the name of component 7"));
  tell(fmt::format("interest {} {}", kDeskId, tools));
  EXPECT_TRUE(until(*island, fmt::format("log mallory writes a subscription in the name of component {}", kDeskId)));
  tell(fmt::format("frame 01b00001.01a00001 7 {} {} a 666", started, tools));
  EXPECT_TRUE(until(*tool, "log mallory (certificate BA) sends frames in the name of component 7: dropped"));
  EXPECT_NE(ask(*tool, "claims"), "0");
  island->write("set a 2\n");
  EXPECT_TRUE(until(*tool, "value 7 a 2"));
  EXPECT_TRUE(until(*tool, "peer 7 home"));
  EXPECT_EQ(ask(*tool, "losses"), "0");
  tool->write("send 7 5\n");
  EXPECT_TRUE(until(*tool, "answered 5"));
  EXPECT_EQ(ask(*tool, "replies"), "5 of 5");
  tool->signal(SIGKILL);
  EXPECT_TRUE(until(*island, "alone")) << "the end of the real one is noticed";
}

/// Numbers of requests rise by one, so they are easy to guess.
TEST_F(TrustedMembers, AnswerNoRequestsToOthers) {
  const auto island = home(), tool = desk();
  meet(*island, *tool);
  const auto tools = ask(*island, fmt::format("incarnation {}", kDeskId));
  const auto mallory = liar();
  ASSERT_TRUE(mallory->line_with("ready"));
  mallory->write(fmt::format("presence {} 1700000000000000\n", kMalloryId));
  ASSERT_TRUE(until(*tool, fmt::format("peer {} mallory", kMalloryId)));
  island->signal(SIGSTOP);
  tool->write("send 7 1\n");
  mallory->write(fmt::format("reply 01b00001.01a00001 {} 1700000000000000 {} {} 1\n", kMalloryId, kDeskId, tools));
  EXPECT_TRUE(until(*tool, fmt::format("log component {} answered a request that it was not asked", kMalloryId)))
      << tool->errors();
  island->signal(SIGCONT);
  EXPECT_TRUE(until(*tool, "answered 1"));
  EXPECT_EQ(ask(*tool, "replies"), "1 of 1") << "as the island answered";
}

TEST_F(TrustedMembers, RenewWhileCommandsPassAndLoseNone) {
  const auto* patience = std::getenv("RUBICON_CHAOS_SECONDS");
  const int times = patience ? 1000 : 50;
  constexpr int kCommands = 600;  // a millisecond each, while a renewal takes more than half a second
  [[maybe_unused]] constexpr long kMostGrowth = 100'000;  // kilobytes
  const auto island = home(), tool = desk();
  meet(*island, *tool);
  [[maybe_unused]] const auto island_before = island->resident_kilobytes();
  [[maybe_unused]] const auto tool_before = tool->resident_kilobytes();
  island->write("set a 0\n");
  tool->write(fmt::format("send 7 {}\n", kCommands * times));
  for (int i = 1; i <= times; ++i) {
    documents(i % 2 == 0 ? kHome : kDesk);
    ASSERT_EQ(ask(i % 2 == 0 ? *island : *tool, "renew"), "done");
    island->write(fmt::format("set a {}\n", i));
    ASSERT_TRUE(until(*tool, fmt::format("value 7 a {}", i))) << tool->errors();
    meet(*island, *tool);
  }
  for (int i = 1; i <= 20; ++i)  // the renewals may be through long before the commands
    ASSERT_TRUE(until(*tool, fmt::format("answered {}", kCommands * times / 20 * i)));
  EXPECT_EQ(ask(*tool, "replies"), fmt::format("{0} of {0}", kCommands * times));
  EXPECT_EQ(ask(*island, "executed"), fmt::format("{} doubled 0", kCommands * times));
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // they keep what was freed
  EXPECT_LT(island->resident_kilobytes() - island_before, kMostGrowth);
  EXPECT_LT(tool->resident_kilobytes() - tool_before, kMostGrowth);
#endif
}

/// Cyclone may have lost the other on one side only: that one begins a handshake which the other does not answer.
TEST_F(TrustedMembers, MeetAgainHoweverLongOneSlept) {
  const auto island = home(), tool = desk();
  meet(*island, *tool);
  for (int i = 0; i < 5; ++i) {
    auto& sleeper = i % 2 == 0 ? *tool : *island;
    sleeper.signal(SIGSTOP);
    std::this_thread::sleep_for(std::chrono::milliseconds(1800 + 400 * i));  // about the lease of two seconds
    sleeper.signal(SIGCONT);
    island->write(fmt::format("set a {}\n", i));
    ASSERT_TRUE(until(*tool, fmt::format("value 7 a {}", i))) << i << tool->errors() << island->errors();
    meet(*island, *tool);
  }
}

TEST_F(TrustedMembers, LeaveWhenTheirCertificateEndsAndComeBackWithANewOne) {
  const auto island = home(), tool = desk();
  meet(*island, *tool);
  tool->write("end-in 3000\n");
  ASSERT_TRUE(tool->line_with("renewed 1"));
  EXPECT_TRUE(until(*tool, "log the certificate of 'desk' ended at"));
  EXPECT_TRUE(until(*tool, "alone"));
  EXPECT_TRUE(until(*island, "alone"));
  tool->write("end-in 3600000\n");
  ASSERT_TRUE(tool->line_with("renewed 1"));
  meet(*island, *tool);
}

TEST_F(TrustedMembers, ComeBackByThemselvesWhenTheirCertificateIsGoodAgain) {
  const auto island = home(), tool = desk();
  meet(*island, *tool);
  tool->write("end-in 3000\n");
  ASSERT_TRUE(tool->line_with("renewed 1"));
  ASSERT_TRUE(until(*tool, "log this process left the ecology"));
  ASSERT_TRUE(until(*island, "alone"));
  tool->write("ends-in 3600000\n");
  EXPECT_TRUE(until(*tool, "log this process is in the ecology again"));
  meet(*island, *tool);
}

TEST_F(TrustedMembers, WhoAreNotKnownForAWhileAreMetLater) {
  const auto tool = desk();
  ASSERT_TRUE(tool->line_with("ready"));
  tool->write("see none\n");
  ASSERT_TRUE(tool->line_with("sees none"));
  const auto island = home();
  ASSERT_TRUE(until(*tool, "log a stranger writes a presence in the name of component 7"));
  EXPECT_TRUE(until(*tool, "alone"));
  tool->write("see others\n");
  meet(*island, *tool);
}

TEST_F(TrustedMembers, WhoAreRevokedAreLostAtOnceAndStayOut) {
  const auto island = home(), tool = desk();
  const auto stolen = member(kMallory, kMalloryId);
  meet(*island, *tool);
  ASSERT_TRUE(until(*island, fmt::format("peer {} mallory", kMalloryId)));
  ASSERT_TRUE(until(*tool, fmt::format("peer {} mallory", kMalloryId)));
  ASSERT_TRUE(until(*stolen, "peer 7 home"));
  stolen->write("send 7 1\n");
  ASSERT_TRUE(until(*stolen, "answered 1"));
  tool->write("revoke 1:BA:signed\n");
  EXPECT_TRUE(until(*tool, "log mallory (certificate BA) is no member any more"));
  EXPECT_TRUE(until(*island, "log mallory (certificate BA) is no member any more")) << "tool told";
  EXPECT_TRUE(until(*stolen, "alone")) << "it reads not even the presence of others";
  meet(*island, *tool);
  stolen->write("send 7 3\n");
  EXPECT_TRUE(until(*stolen, "answered 4"));
  EXPECT_EQ(ask(*stolen, "replies"), "1 of 4");
  EXPECT_EQ(ask(*island, "executed"), "1 doubled 0");
  EXPECT_THAT(island->errors(), Not(HasSubstr("a stranger writes")))
      << "who was named once is not named for each sample";
  const auto late = member(Person{"roof", "00000009-00000009", "00000009", 9}, 9);
  EXPECT_TRUE(until(*late, "peer 7 home"));
  EXPECT_TRUE(until(*late, "revoked 1:BA:signed")) << "from any of them";
}

/// She never was a component that others know, and reads what all may read.
TEST_F(TrustedMembers, WhoAreRevokedReadNoMoreEvenIfTheyNeverShowedThemselves) {
  const auto island = home();
  ASSERT_TRUE(island->line_with("ready"));
  const auto mallory = liar();
  ASSERT_TRUE(mallory->line_with("ready"));
  ASSERT_EQ(ask(*mallory, "readers"), "2");
  island->write("revoke 1:BA:signed\n");
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  std::string readers;
  do readers = ask(*mallory, "readers");
  while (readers != "0" && std::chrono::steady_clock::now() < end);
  EXPECT_EQ(readers, "0") << island->errors();
  EXPECT_TRUE(until(*desk(), "peer 7 home")) << "the island is there again, without her";
}

TEST_F(TrustedMembers, ObeyAListThatAReloadFinds) {
  const auto island = home(), thief = member(kMallory, kMalloryId);
  ASSERT_TRUE(until(*thief, "peer 7 home"));
  ASSERT_TRUE(until(*island, fmt::format("peer {} mallory", kMalloryId)));
  thief->write("send 7 1\n");
  ASSERT_TRUE(until(*thief, "answered 1"));
  island->write("lay 1:BA:signed\n");
  EXPECT_EQ(ask(*island, "reload"), "done");
  thief->write("send 7 20\n");
  ASSERT_TRUE(until(*thief, "answered 21"));
  EXPECT_EQ(ask(*thief, "replies"), "1 of 21");
  EXPECT_TRUE(until(*thief, "alone"));
}

TEST_F(TrustedMembers, LeaveWhenTheyAreRevokedThemselves) {
  const auto island = home(), tool = desk();
  meet(*island, *tool);
  island->write("revoke 1:home:signed\n");
  EXPECT_TRUE(until(*island, "log the certificate of home was revoked"));
  EXPECT_TRUE(until(*island, "alone"));
  EXPECT_TRUE(until(*tool, "alone"));
}

}  // namespace
}  // namespace rubicon::tuples::dds
