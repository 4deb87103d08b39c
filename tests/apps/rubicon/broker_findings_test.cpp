#include "apps/rubicon/doctor/broker_findings.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model/findings.h"

namespace rubicon::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using Grade = Finding::Grade;

constexpr WallTime kCheckedAt = std::chrono::sys_days(std::chrono::year(2026) / 11 / 23);

BrokerSeen good_broker() {
  BrokerSeen broker;
  broker.place = "broker.test:8883";
  broker.space = "city";
  broker.user = "desk";
  broker.tls = broker.hands_on = true;
  broker.users = {{"hall", {OwnerId(1), OwnerId(70000)}}, {"desk", {OwnerId(70001)}}};
  return broker;
}

RealmSeen good_realm() {
  RealmSeen seen;
  seen.realm.name = "Rubicon 5f1c";
  seen.realm.number = seen.on_disk = 7;
  seen.realm.members = {{"hall", {}}, {"desk", {"admin"}}};
  seen.folder = "/etc/rubicon/realm";
  seen.own_ends = kCheckedAt + std::chrono::days(300);
  seen.authority_days_left = 3000;
  return seen;
}

/// Those that are not good: grade, what and fix.
std::vector<std::string> ill(const Findings& all) {
  std::vector<std::string> lines;
  for (const auto& one : all) {
    EXPECT_EQ(one.check, "sites");
    if (one.grade == Grade::kGood) continue;
    EXPECT_FALSE(one.fix.empty()) << one.what;
    lines.push_back(fmt::format("{}: {} -> {}", to_string(one.grade), one.what, one.fix));
  }
  return lines;
}

std::string failure(std::string_view finding) {
  BrokerSeen broker;
  broker.failure = Error{ErrorCode::kRefused, "a sentence", finding};
  const auto lines = ill(check_broker(broker, nullptr, kCheckedAt));
  EXPECT_THAT(lines, SizeIs(1));
  return lines.empty() ? "" : lines[0];
}

TEST(BrokerFindings, NothingIsSaidAgainstWhatIsWell) {
  const auto realm = good_realm();
  const auto all = check_broker(good_broker(), &realm, kCheckedAt);
  EXPECT_THAT(ill(all), IsEmpty());
  ASSERT_THAT(all, SizeIs(2));
  EXPECT_EQ(all[0].what,
            "connected with the broker broker.test:8883 as desk, by MQTT 5 with TLS; space city has 3 components of 2 "
            "users");
  EXPECT_EQ(all[1].what, "the rights of the broker broker.test:8883 protect others from desk");
}

TEST(BrokerFindings, WhyThereIsNoConnectionHasARemedy) {
  using namespace model::findings;
  EXPECT_THAT(failure(kHostUnknown), HasSubstr("-> compare `host` with the name of the broker's host"));
  EXPECT_THAT(failure(kConnectionRefused), HasSubstr("no broker listens there"));
  EXPECT_THAT(failure(kCertificateName), HasSubstr("certificate for another name"));
  EXPECT_THAT(failure(kCertificateAuthority), HasSubstr("ca.pem of the realm"));
  EXPECT_THAT(failure(kTlsEnds), HasSubstr("was revoked"));
  EXPECT_THAT(failure(kLoginRefused), HasSubstr("its password is another one"));
  EXPECT_THAT(failure(kHostSilent), HasSubstr("the host is off"));
  EXPECT_THAT(failure(""), HasSubstr("sites.md"));
}

TEST(BrokerFindings, WhatABrokerDoesNotDoIsAProblem) {
  auto broker = good_broker();
  broker.forges = true;
  EXPECT_THAT(ill(check_broker(broker, nullptr, kCheckedAt)).at(0),
              AllOf(HasSubstr("note: the broker broker.test:8883 lets desk write in the name of others"),
                    HasSubstr("the four rights")));
  broker.hands_on = false;
  EXPECT_THAT(ill(check_broker(broker, nullptr, kCheckedAt)).at(0), HasSubstr("problem: "));
  broker.retains = false;
  EXPECT_THAT(ill(check_broker(broker, nullptr, kCheckedAt)).at(0), HasSubstr("keeps no retained messages"));
}

TEST(BrokerFindings, UsersThatTheRealmDoesNotHaveAreNamed) {
  auto realm = good_realm();
  auto broker = good_broker();
  broker.users["stranger"] = {};
  broker.users["gone"] = {};
  realm.realm.revoked = {"gone"};
  broker.ghosts = {{"hall", OwnerId(70000)}};
  const auto lines = ill(check_broker(broker, &realm, kCheckedAt));
  ASSERT_THAT(lines, SizeIs(3));
  EXPECT_THAT(lines[0],
              HasSubstr("note: the broker broker.test:8883 has 1 component without a connection: 70000 of hall"));
  EXPECT_THAT(lines[1], HasSubstr("note: the broker broker.test:8883 still has presence of who was shut out: gone"));
  EXPECT_THAT(lines[2], HasSubstr("problem: the broker broker.test:8883 has users that the realm Rubicon 5f1c does not "
                                  "have: stranger"));
  EXPECT_THAT(ill(check_broker(broker, nullptr, kCheckedAt)), SizeIs(1)) << "without a realm nobody is a stranger";
}

TEST(BrokerFindings, WhatIsOldOrEndsSoonIsNamed) {
  auto realm = good_realm();
  realm.on_disk = 5;
  realm.shown_by = "hall";
  realm.own_ends = kCheckedAt + std::chrono::days(12);
  realm.authority_days_left = -1;
  const auto lines = ill(check_broker(good_broker(), &realm, kCheckedAt));
  ASSERT_THAT(lines, SizeIs(3));
  EXPECT_THAT(lines[0],
              HasSubstr("note: the realm file in /etc/rubicon/realm has number 5, the one that hall shows has 7"));
  EXPECT_THAT(lines[1],
              AllOf(HasSubstr("note: the certificate of desk ends in 12 days"), HasSubstr("rubicon trust renew desk")));
  EXPECT_THAT(lines[2], HasSubstr("problem: the authority of the realm Rubicon 5f1c has ended"));
  realm = good_realm();
  realm.open_keys = {"/etc/rubicon/realm/members/desk/key.pem"};
  EXPECT_THAT(ill(check_broker(good_broker(), &realm, kCheckedAt)).at(0),
              AllOf(HasSubstr("problem: /etc/rubicon/realm/members/desk/key.pem: others may read"),
                    HasSubstr("chmod 600 /etc/rubicon/realm/members/desk/key.pem")));
  realm = good_realm();
  realm.realm.members.erase("desk");
  EXPECT_THAT(ill(check_broker(good_broker(), &realm, kCheckedAt)).at(0), HasSubstr("problem: desk is not a member"));
  realm.realm.revoked = {"desk"};
  EXPECT_THAT(ill(check_broker(good_broker(), &realm, kCheckedAt)).at(0), HasSubstr("problem: desk was shut out"));
}

TEST(BrokerFindings, WhatAnIslandLosesDuringTheCheckIsANote) {
  IslandSeen seen;
  seen.island.id = OwnerId(1);
  EXPECT_THAT(check_broker_losses(seen), IsEmpty());
  seen.known_before = true;
  seen.numbers_before = {{"mqtt-reconnects", 2}, {"mqtt-gaps", 5}};
  seen.numbers = {{"mqtt-reconnects", 3}, {"mqtt-gaps", 5}, {"mqtt-frames-again", 7}};
  const auto all = check_broker_losses(seen);
  ASSERT_THAT(all, SizeIs(3));
  EXPECT_EQ(all[0].what, "island 1 lost its broker and found it again: 3 since its start, 1 during the check");
  EXPECT_EQ(all[1].grade, Grade::kGood);
  EXPECT_THAT(ill(all), SizeIs(2));
}

}  // namespace
}  // namespace rubicon::cli
