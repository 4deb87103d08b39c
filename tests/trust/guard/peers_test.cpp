#include "trust/guard/peers.h"

#include <gtest/gtest.h>

namespace rubicon::trust::guard {
namespace {

using namespace std::chrono_literals;

GuidPrefix prefix(std::size_t number) {
  GuidPrefix made{};
  for (std::size_t i = 0; i < 4; ++i) made[i] = static_cast<std::uint8_t>(number >> (8 * i));
  return made;
}

Handle handle(std::size_t number) {
  return static_cast<Handle>(number) + 1;
}

Certificate certificate(const std::string& name, const std::string& serial = "01") {
  Certificate made;
  made.name = name;
  made.serial = serial;
  return made;
}

TEST(Peers, AreKnownAfterTheirHandshakeUntilTheyGo) {
  Peers peers;
  ASSERT_TRUE(peers.met(1, prefix(7)));
  peers.shakes_hands(100, 1);
  ASSERT_TRUE(peers.of_handshake(100));
  EXPECT_EQ(peers.of_handshake(100)->prefix, prefix(7));
  EXPECT_FALSE(peers.who(prefix(7)));
  peers.authenticated(1, certificate("desk"));
  EXPECT_EQ(peers.who(prefix(7))->name, "desk");
  peers.gone(1);
  EXPECT_FALSE(peers.who(prefix(7)));
  EXPECT_FALSE(peers.of_handshake(100));
  EXPECT_EQ(peers.size(), 0U);
}

TEST(Peers, AreForgottenWhenTheyAreRevoked) {
  Peers peers;
  peers.met(1, prefix(7));
  peers.authenticated(1, certificate("desk", "0ABC"));
  peers.revoke({"0ABC"});
  EXPECT_FALSE(peers.who(prefix(7)));
  EXPECT_TRUE(peers.is_revoked("0ABC"));
  peers.revoke({});
  EXPECT_TRUE(peers.who(prefix(7)));
}

TEST(Peers, AHandshakeThatBeginsAgainIsNotAnother) {
  Peers peers;
  peers.met(1, prefix(7));
  for (int i = 0; i < 1000; ++i) {
    peers.met(1, prefix(7));
    peers.shakes_hands(100, 1);
  }
  EXPECT_EQ(peers.size(), 1U);
  EXPECT_TRUE(peers.of_handshake(100));
}

TEST(Peers, OldHandshakesOfOneStrangerGo) {
  Peers peers;
  peers.met(1, prefix(7));
  for (Handle handshake = 100; handshake < 1100; ++handshake) peers.shakes_hands(handshake, 1);
  EXPECT_FALSE(peers.of_handshake(100));
  EXPECT_TRUE(peers.of_handshake(1099));
}

TEST(Peers, ACrowdOfStrangersNeitherGrowsTheTableNorDisplacesMembers) {
  Peers peers;
  peers.met(handle(0), prefix(0));
  peers.authenticated(handle(0), certificate("desk"));
  for (std::size_t i = 1; i < 3 * Peers::kMost; ++i) ASSERT_TRUE(peers.met(handle(i), prefix(i)));
  EXPECT_EQ(peers.size(), Peers::kMost);
  EXPECT_EQ(peers.who(prefix(0))->name, "desk");
}

TEST(Peers, ACrowdOfStrangersDoesNotDisplaceAMemberThatShakesHands) {
  Peers peers;
  peers.met(handle(0), prefix(0));
  peers.shakes_hands(100'000, handle(0));
  for (std::size_t i = 1; i <= Peers::kMost + 1; ++i) ASSERT_TRUE(peers.met(handle(i), prefix(i)));
  ASSERT_TRUE(peers.of_handshake(100'000));
  peers.authenticated(handle(0), certificate("desk"));
  EXPECT_EQ(peers.who(prefix(0))->name, "desk");
}

TEST(Peers, ThatOnlyBeginAHandshakeGoToo) {
  Peers peers;
  for (std::size_t i = 0; i < 2 * Peers::kMost; ++i) {
    ASSERT_TRUE(peers.met(handle(i), prefix(i)));
    peers.shakes_hands(static_cast<Handle>(100'000 + i), handle(i));
  }
  EXPECT_EQ(peers.size(), Peers::kMost);
  EXPECT_FALSE(peers.of_handshake(100'000));
}

TEST(Peers, AHandshakeThatIsOverIsForgotten) {
  Peers peers;
  peers.met(1, prefix(7));
  peers.shakes_hands(100, 1);
  peers.is_over(100);
  EXPECT_FALSE(peers.of_handshake(100));
  EXPECT_EQ(peers.prefix_of(1), prefix(7));
  peers.is_over(100);
}

TEST(Peers, WhoseHandshakesFailWaitLongerEachTime) {
  Peers peers;
  const Clock::time_point start{};
  peers.met(1, prefix(7));
  EXPECT_FALSE(peers.must_wait(1, start));
  peers.failed(1, start);
  EXPECT_TRUE(peers.must_wait(1, start));
  EXPECT_TRUE(peers.must_wait(1, start + Peers::kShortestWait - 1ms));
  EXPECT_FALSE(peers.must_wait(1, start + Peers::kShortestWait));
  const auto second = start + Peers::kShortestWait;
  peers.failed(1, second);
  EXPECT_TRUE(peers.must_wait(1, second + 2 * Peers::kShortestWait - 1ms));
  EXPECT_FALSE(peers.must_wait(1, second + 2 * Peers::kShortestWait));
  for (int i = 0; i < 1000; ++i) peers.failed(1, second);
  EXPECT_TRUE(peers.must_wait(1, second + Peers::kLongestWait - 1ms));
  EXPECT_FALSE(peers.must_wait(1, second + Peers::kLongestWait));
}

TEST(Peers, AHandshakeThatSucceedsEndsTheWait) {
  Peers peers;
  const Clock::time_point start{};
  peers.met(1, prefix(7));
  for (int i = 0; i < 10; ++i) peers.failed(1, start);
  peers.authenticated(1, certificate("desk"));
  EXPECT_FALSE(peers.must_wait(1, start));
  peers.failed(1, start);
  EXPECT_FALSE(peers.must_wait(1, start + Peers::kShortestWait));
}

/// Anyone can send a bad message in the name of a peer.
TEST(Peers, AHandshakeThatAPeerBeginsWaitsOnlyIfItsCertificateWasForeignBefore) {
  Peers peers;
  const Clock::time_point start{};
  peers.met(1, prefix(7));
  peers.failed(1, start);
  EXPECT_FALSE(peers.must_wait(1, "its certificate", start)) << "what else was wrong may be of another";
  peers.failed(1, start, "a foreign certificate");
  EXPECT_TRUE(peers.must_wait(1, "a foreign certificate", start));
  EXPECT_FALSE(peers.must_wait(1, "its certificate", start));
  EXPECT_FALSE(peers.must_wait(1, "", start));
  EXPECT_FALSE(peers.must_wait(1, "a foreign certificate", start + Peers::kLongestWait));
  EXPECT_FALSE(peers.must_wait(2, "a foreign certificate", start));
}

TEST(Peers, WhoIsRevokedIsMetUntilItIsGone) {
  Peers peers;
  peers.met(1, prefix(7));
  peers.revoke({certificate("desk").serial});
  EXPECT_FALSE(peers.meets_revoked()) << "it has not authenticated itself";
  peers.authenticated(1, certificate("desk"));
  EXPECT_TRUE(peers.meets_revoked());
  peers.gone(1);
  EXPECT_FALSE(peers.meets_revoked());
}

TEST(Peers, OneThatFailsKeepsNoOtherWaiting) {
  Peers peers;
  const Clock::time_point start{};
  peers.met(1, prefix(7));
  peers.met(2, prefix(8));
  peers.failed(1, start);
  EXPECT_FALSE(peers.must_wait(2, start));
  peers.gone(1);
  peers.met(1, prefix(9));  // another at the same address
  EXPECT_FALSE(peers.must_wait(1, start));
  peers.failed(3, start);
  EXPECT_FALSE(peers.must_wait(3, start));
}

TEST(Peers, ATableFullOfMembersTakesNoOther) {
  Peers peers;
  for (std::size_t i = 0; i < Peers::kMost; ++i) {
    peers.met(handle(i), prefix(i));
    peers.authenticated(handle(i), certificate("desk"));
  }
  EXPECT_FALSE(peers.met(handle(Peers::kMost), prefix(Peers::kMost)));
}

}  // namespace
}  // namespace rubicon::trust::guard
