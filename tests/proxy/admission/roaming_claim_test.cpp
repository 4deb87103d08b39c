#include "proxy/admission/roaming_claims.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "proxy/admission/command_transfer.h"
#include "proxy/island.h"

namespace rubicon::proxy::admission {
namespace {

using testing::HasSubstr;

WallTime at(std::int64_t micros) {
  return WallTime(std::chrono::microseconds(micros));
}

Claim claim(std::uint32_t island, std::int64_t since, const std::string& network = "wsn-1") {
  return {OwnerId(island), "proxy." + network + ".7", network, "7", "7", at(since), true};
}

TEST(RoamingClaim, TheNewestJoinIsBetterThenTheLowerIslandThenTheLowerNetwork) {
  EXPECT_TRUE(better(claim(2, 101), claim(1, 100)));
  EXPECT_FALSE(better(claim(1, 100), claim(2, 101)));
  EXPECT_TRUE(better(claim(1, 100), claim(2, 100)));
  EXPECT_FALSE(better(claim(2, 100), claim(1, 100)));
  EXPECT_TRUE(better(claim(1, 100, "wsn-1"), claim(1, 100, "wsn-2")));
  EXPECT_TRUE(better(claim(9, 1), claim(1, 0))) << "a join is better than none";
}

TEST(RoamingClaim, HasTheKeyOfItsAddressOrOfATwin) {
  const Identity identity{"lab", "1.7"};
  for (const auto* key : {"ROAMING.lab.1_7", "ROAMING.lab.1_7-2", "ROAMING.lab.1_7-31"})
    EXPECT_TRUE(is_claim_key(key, identity)) << key;
  for (const auto* key : {"ROAMING.lab.1_8", "ROAMING.lab.1_71", "ROAMING.lab.1_7-1", "ROAMING.lab.1_7-x",
                          "ROAMING.lab.1_7-", "ROAMING.lab.1_7-2-3", "ROAMING.attic.1_7", "ROAMING.lab.1"})
    EXPECT_FALSE(is_claim_key(key, identity)) << key;
}

TEST(RoamingClaim, NoClaimIsBetterThanItselfAndOfTwoDifferentOnesExactlyOneIs) {
  std::vector<Claim> all;
  for (const std::int64_t since : {0, 1, 2}) {
    for (const std::uint32_t island : {1U, 2U}) {
      for (const auto* network : {"a", "b"}) all.push_back(claim(island, since, network));
    }
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = 0; j < all.size(); ++j) {
      EXPECT_EQ(better(all[i], all[j]) + better(all[j], all[i]), i == j ? 0 : 1) << i << " " << j;
    }
  }
  auto one_way = all, other_way = all;
  std::reverse(other_way.begin(), other_way.end());
  std::sort(one_way.begin(), one_way.end(), better);
  std::sort(other_way.begin(), other_way.end(), better);
  EXPECT_EQ(one_way, other_way) << "whatever the order of arrival, the same one is the best";
}

TEST(RoamingClaim, ReadsAsItWasWrittenToTheMicrosecond) {
  for (const std::int64_t since :
       {0L, 1L, 1767225600000001L, 1767225600999999L, 4102444800123457L, 7258118399999999L}) {
    auto one = claim(6541, since);
    one.address = "\"1.4.6\" \\ \xc3\xa4";
    const auto read = parse_claim(OwnerId(6541), claim_text(one));
    ASSERT_TRUE(read) << read.error().text;
    EXPECT_EQ(*read, one) << since;
  }
}

TEST(RoamingClaim, SaysWhatIsWrong) {
  const auto error = [](const std::string& text) {
    const auto read = parse_claim(OwnerId(1), text);
    return read ? std::string("nothing") : read.error().text;
  };
  const std::string good = R"("key":"proxy.a.7","network":"a","device":"7","address":"7")";
  EXPECT_EQ(error("{" + good + R"(,"since":1,"more":[]})"), "nothing") << "newer islands may say more";
  EXPECT_THAT(error(""), HasSubstr("JSON object"));
  EXPECT_THAT(error("[" + std::string(100000, '[')), HasSubstr("JSON object"));
  EXPECT_THAT(error("{}"), HasSubstr("key of the device"));
  EXPECT_THAT(error(R"({"key":"proxy..7","network":"a","device":"7","address":"7","since":1})"), HasSubstr("key"));
  EXPECT_THAT(error(R"({"key":"p.a.7","network":"a b","device":"7","address":"7","since":1})"), HasSubstr("network"));
  EXPECT_THAT(error(R"({"key":"p.a.7","network":"a","device":"7","address":"","since":1})"), HasSubstr("address"));
  EXPECT_THAT(error("{" + good + "}"), HasSubstr("since"));
  EXPECT_THAT(error("{" + good + R"(,"since":-1})"), HasSubstr("since"));
  EXPECT_THAT(error("{" + good + R"(,"since":1e12})"), HasSubstr("since"));
  EXPECT_THAT(error("{" + good + R"(,"since":"1"})"), HasSubstr("since"));
}

TEST(RoamingClaim, ItsKeyIsMadeOfDomainAndAddress) {
  EXPECT_EQ(claim_key({"lab", "1.4.6"}), "ROAMING.lab.1_4_6");
}

/// What an island claims of its own devices.
class OwnClaim : public Island {};

TEST_F(OwnClaim, IsNotOlderBecauseTheNetworkListsTheDeviceAgain) {
  rules().roaming = "lab";
  start();
  join("7", lamp());
  const auto since = json("ROAMING.lab.7")["since"];
  time.run_for(5s);
  auto listed = lamp();
  listed.heard = false;
  join("7", listed);
  EXPECT_EQ(json("ROAMING.lab.7")["since"], since);
}

TEST_F(OwnClaim, IsMadeAtOnceOfADeviceWhoseIslandLeft) {
  rules().roaming = "lab";
  start();
  auto far_link = *ecology.join(OwnerId(2));
  auto far = std::make_unique<TupleSpace>(OwnerId(2), time, *far_link);
  time.run_for(5s);
  join("7", lamp());
  time.run_for(5s);
  const auto theirs = claim(2, time.wall_now().time_since_epoch().count());
  ASSERT_TRUE(far->set("ROAMING.lab.7", claim_text(theirs), {.media_type = "application/json"}));
  time.run_for(5s);
  ASSERT_FALSE(exists("proxy.hall.7.status")) << "it is there";
  far.reset();
  far_link.reset();
  time.run_ready();
  say("7", model::KeepAlive{});
  EXPECT_TRUE(exists("proxy.hall.7.status"));
}

TEST(WaitingCommand, ReadsAsItWasWritten) {
  const WaitingCommand one{{Kind::kActuator, TypeId{77}, "1"}, "on \"x\"", OwnerId(70001), 1ULL << 60};
  const auto read = parse_waiting_command(waiting_command_text(one));
  ASSERT_TRUE(read) << read.error().text;
  EXPECT_EQ(*read, one);
}

TEST(WaitingCommand, SaysWhatIsWrong) {
  const auto wrong = [](const std::string& text) { return !parse_waiting_command(text); };
  const std::string rest = R"("type":1,"instance":"1","value":"on","creator":1,"request":1})";
  EXPECT_FALSE(wrong(R"({"kind":"property",)" + rest));
  EXPECT_TRUE(wrong(R"({"kind":"sensor",)" + rest)) << "nobody commands a sensor";
  EXPECT_TRUE(wrong("{" + rest));
  EXPECT_TRUE(wrong(R"({"kind":"actuator","type":70000,"instance":"1","value":"on","creator":1,"request":1})"));
  EXPECT_TRUE(wrong(R"({"kind":"actuator","type":1,"value":"on","creator":1,"request":1})"));
  EXPECT_TRUE(wrong(R"({"kind":"actuator","type":1,"instance":"1","creator":1,"request":1})"));
  EXPECT_TRUE(wrong(R"({"kind":"actuator","type":1,"instance":"1","value":"on","creator":-1,"request":1})"));
  EXPECT_TRUE(wrong(R"({"kind":"actuator","type":1,"instance":"1","value":"on","creator":1,"request":1.5})"));
}

}  // namespace
}  // namespace rubicon::proxy::admission
