#include "web/access/access.h"

#include <gmock/gmock.h>

#include "base/virtual_scheduler.h"

namespace rubicon::web::access {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

TEST(Sha256, IsThatOfTheStandard) {
  const auto digest = sha256("abc");  // FIPS 180-4, example
  EXPECT_EQ(hex(digest.data(), digest.size()), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_TRUE(same(digest, sha256("abc")));
  EXPECT_FALSE(same(digest, sha256("abd")));
}

TEST(Secrets, Have128BitsAndAreNeverTheSame) {
  EXPECT_EQ(random_secret().size(), 32U);
  EXPECT_NE(random_secret(), random_secret());
}

TEST(OriginRules, OurHostsAreAddressesLocalhostAndListedNames) {
  const OriginRules rules{.hosts = {"hall.lan"}, .origins = {}};
  for (const auto* ours :
       {"127.0.0.1", "192.168.1.5:8642", "[::1]", "[fe80::1]:8642", "localhost", "LOCALHOST:1", "Hall.LAN"})
    EXPECT_TRUE(rules.is_own_host(ours)) << ours;
  for (const auto* foreign : {"", ":8642", "evil.example", "hall.lan.evil.example", "127.0.0.1.evil.example", "::1",
                              "localhost.", "localhost:0", "localhost:x", "a@localhost", "localhost/", "[::1",
                              "0x7f000001", "127.1", "2130706433", " localhost"})
    EXPECT_FALSE(rules.is_own_host(foreign)) << foreign;
}

TEST(OriginRules, OurOriginHasOurHostOurPortAndOurScheme) {
  const OriginRules rules{.hosts = {}, .origins = {"https://hall.lan"}};
  EXPECT_TRUE(rules.is_own_origin("http://localhost:8642", "localhost:8642", false));
  EXPECT_TRUE(rules.is_own_origin("http://localhost", "localhost:80", false));
  EXPECT_TRUE(rules.is_own_origin("https://LOCALHOST", "localhost", true));
  EXPECT_TRUE(rules.is_own_origin("https://localhost:443", "localhost", true));
  EXPECT_TRUE(rules.is_own_origin("https://hall.lan", "127.0.0.1:8642", false)) << "a listed one: behind a proxy";
  EXPECT_FALSE(rules.is_own_origin("https://localhost:8642", "localhost:8642", false));
  EXPECT_FALSE(rules.is_own_origin("http://localhost:8643", "localhost:8642", false));
  EXPECT_FALSE(rules.is_own_origin("http://127.0.0.1:8642", "localhost:8642", false));
  EXPECT_FALSE(rules.is_own_origin("http://localhost:8642.evil.example", "localhost:8642", false));
  EXPECT_FALSE(rules.is_own_origin("https://hall.lan.evil.example", "127.0.0.1:8642", false));
  EXPECT_FALSE(rules.is_own_origin("null", "localhost:8642", false));
  EXPECT_FALSE(rules.is_own_origin("", "", false));
}

TEST(Attempts, FiveFailuresAMinuteAreForgottenOneByOne) {
  Attempts attempts;
  SteadyTime now{};
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(attempts.may_try("10.0.0.1", now));
    attempts.failed("10.0.0.1", now);
    now += 10s;
  }
  EXPECT_FALSE(attempts.may_try("10.0.0.1", now));
  EXPECT_TRUE(attempts.may_try("10.0.0.2", now));
  EXPECT_TRUE(attempts.may_try("10.0.0.1", now + 10s)) << "the first is a minute old";
}

TEST(Attempts, ANetworkOfIpv6CountsAsOne) {
  Attempts attempts;
  for (int i = 1; i <= 5; ++i) attempts.failed("2001:db8:1:2::" + std::to_string(i), {});
  EXPECT_FALSE(attempts.may_try("2001:db8:1:2:ffff::7", {}));
  EXPECT_TRUE(attempts.may_try("2001:db8:1:3::1", {}));
}

TEST(Attempts, ManyAddressesCostBoundedMemoryAndGetNoMoreGuesses) {
  Attempts attempts;
  for (int i = 0; i < 5000; ++i) attempts.failed("10.0." + std::to_string(i / 250) + "." + std::to_string(i % 250), {});
  EXPECT_LE(attempts.addresses(), Attempts::kMaxAddressCount + 1);
  EXPECT_FALSE(attempts.may_try("10.9.9.9", {})) << "shares the count of the rest";
}

TEST(Sessions, AreBoundedAndTheLongestIdleGoes) {
  Sessions sessions;
  const auto first = sessions.open(sha256("a"), {});
  const auto second = sessions.open(sha256("a"), {});
  for (std::size_t i = 2; i < Sessions::kMaxCount; ++i) sessions.open(sha256("b"), SteadyTime(1s));
  EXPECT_TRUE(sessions.find(first, SteadyTime(2s)));
  sessions.open(sha256("c"), SteadyTime(3s));
  EXPECT_EQ(sessions.size(), Sessions::kMaxCount);
  EXPECT_TRUE(sessions.find(first, SteadyTime(4s)));
  EXPECT_FALSE(sessions.find(second, SteadyTime(4s)));
}

TEST(Sessions, EndAfterAWeekAlsoWhereTheyAreUsed) {
  Sessions sessions;
  const auto secret = sessions.open(sha256("a"), {});
  SteadyTime now{};
  for (; now < SteadyTime(160h); now += 8h) EXPECT_TRUE(sessions.find(secret, now));
  EXPECT_FALSE(sessions.find(secret, SteadyTime(168h)));
}

TEST(Sessions, AConversationRenewsItsSessionUntilItEnds) {
  Sessions sessions;
  const auto secret = sessions.open(sha256("a"), {});
  const auto id = sessions.find(secret, {})->id;
  EXPECT_TRUE(sessions.renew(id, SteadyTime(11h)));
  EXPECT_TRUE(sessions.find(secret, SteadyTime(22h)));
  EXPECT_FALSE(sessions.renew(id, SteadyTime(34h)));
  EXPECT_FALSE(sessions.renew(id, SteadyTime(34h))) << "it is not there any longer";
}

const std::string kHash(64, 'a');

TEST(TokenFile, HasALineForEachToken) {
  const auto tokens = parse_tokens("# who\n\nviewer:view:" + kHash + "\r\n worker : command : " + kHash +
                                   " # tablet\nowner:admin:" + kHash);
  ASSERT_TRUE(tokens) << tokens.error().text;
  ASSERT_EQ(tokens->size(), 3U);
  EXPECT_EQ(tokens->at(1).name, "worker");
  EXPECT_EQ(tokens->at(1).role, Role::kCommand);
  EXPECT_EQ(tokens->at(2).hash, Digest{tokens->at(0).hash});
}

TEST(TokenFile, WhatIsWrongIsSaidWithItsLine) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"a", "line 1: expected name:role:hash"},
      {"a:view", "line 1: expected name:role:hash"},
      {"\na:root:" + kHash, "line 2: expected name:role:hash"},
      {"a:none:" + kHash, "expected name:role:hash"},
      {"a:view:" + kHash + "a", "expected name:role:hash"},
      {"a:view:" + std::string(64, 'g'), "expected name:role:hash"},
      {":view:" + kHash, "line 1: expected a name"},
      {"a b:view:" + kHash, "line 1: expected a name"},
      {"a:view:" + kHash + "\na:admin:" + kHash, "line 2: 'a' has a token already"},
  };
  for (const auto& [text, part] : cases) {
    const auto tokens = parse_tokens(text);
    ASSERT_FALSE(tokens) << text;
    EXPECT_THAT(tokens.error().text, HasSubstr(part));
  }
}

TEST(Roles, EachIncludesThoseBeforeIt) {
  const auto caller = [](Role role) { return Caller{"x", role, "127.0.0.1"}; };
  const auto island = OwnerId(7);
  struct Right {
    Verb verb;
    const char* key;
    Role least;
  };
  const std::vector<Right> rights{
      {Verb::kRead, "proxy.**", Role::kView},
      {Verb::kWake, "proxy.wsn-1.7.sensor.light-1.value", Role::kView},
      {Verb::kSet, "proxy.dummy-1.room.actuator.lamp-1.command", Role::kCommand},
      {Verb::kSend, "knx", Role::kCommand},
      {Verb::kSend, "knx.request", Role::kCommand},
      {Verb::kSend, "zigbee.request", Role::kCommand},
      {Verb::kSend, "zigbee.admin", Role::kAdmin},
      {Verb::kSend, "other.bridge.admin", Role::kAdmin},
      {Verb::kSend, "zigbee.administrators", Role::kCommand},
      {Verb::kSet, "proxy.inbox", Role::kAdmin},
      {Verb::kSet, "other.inbox.wsn-1.7", Role::kAdmin},
      {Verb::kSet, "proxy.settings.command", Role::kAdmin},
      {Verb::kSet, "proxy.recorder.night.command", Role::kAdmin},
      {Verb::kSet, "GATEWAY", Role::kAdmin},
      {Verb::kSet, "RUBICON_GATEWAY.7", Role::kAdmin},
      {Verb::kSet, "proxy.inboxes", Role::kCommand},
      {Verb::kSet, "proxy.log.level.command", Role::kAdmin},
      {Verb::kSet, "proxy.log.property.replay-state.command", Role::kCommand},
      {Verb::kSet, "proxy.knx-hall.property.line.command", Role::kAdmin},
      {Verb::kSet, "proxy.knx-hall.1_4_6.description", Role::kAdmin},
      {Verb::kSet, "proxy.knx-hall.1_4_6.actuator.lamp-1.description", Role::kCommand},
      {Verb::kSet, "proxy.overview", Role::kCommand},
      {Verb::kSet, "proxy.knx-hall.property.replay-state.command", Role::kCommand},
      {Verb::kSet, "proxy.knx-hall.1_4_6.property.line-1.command", Role::kCommand},
      {Verb::kSet, "proxy.recorder.7.actuator.switch-1.command", Role::kCommand},
  };
  for (const auto& right : rights) {
    for (const auto role : {Role::kNone, Role::kView, Role::kCommand, Role::kAdmin})
      EXPECT_EQ(may(caller(role), right.verb, island, right.key), role >= right.least)
          << right.key << " " << to_string(role);
  }
}

}  // namespace
}  // namespace rubicon::web::access
