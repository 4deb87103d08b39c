#include "trust/certificate.h"

#include <gtest/gtest.h>

#include "trust/certificate_request.h"
#include "trust/id_ranges.h"
#include "trust/now.h"
#include "trust/operations.h"
#include "trust/realm.h"

namespace rubicon::trust {
namespace {

constexpr WallTime kEnd = std::chrono::sys_days(std::chrono::year(2028) / 1 / 1);

/// Two realms and a key of a member.
class CertificateTest : public testing::Test {
 protected:
  Authority home_ = *Authority::make("Rubicon", kNow);
  Authority other_ = *Authority::make("Other", kNow);
  PrivateKey key_ = *PrivateKey::make();

  CertificateOrder order(const std::string& name = "desk") const {
    return {home_.realm.identity().name, name, {{7, 7}, block_range(0x1a)}, {"admin", "panel"}, kEnd, key_.get()};
  }
  Certificate issued(const CertificateOrder& order) const {
    return *issue(order, home_.realm.identity_ca, home_.identity_key);
  }
};

TEST_F(CertificateTest, SaysWhoTheMemberIs) {
  const auto certificate = issued(order());
  const auto member = certificate.member("x");
  ASSERT_TRUE(member) << member.error().text;
  EXPECT_EQ(member->name, "desk");
  EXPECT_EQ(member->roles, (std::vector<std::string>{"admin", "panel"}));
  EXPECT_EQ(ranges_text(member->ids), "00000007-00000007,01a00000-01afffff");
  EXPECT_EQ(member->serial.size(), 32U);
  EXPECT_EQ(member->expires, kEnd);
  EXPECT_EQ(certificate.subject(), "CN=desk,O=" + home_.realm.identity().name);
  EXPECT_EQ(certificate.begins(), WallTime(std::chrono::sys_days(std::chrono::year(2020) / 1 / 1)));
  const auto again = Certificate::of_pem(certificate.pem(), "x");
  ASSERT_TRUE(again);
  EXPECT_EQ(*again, certificate);
}

TEST_F(CertificateTest, SerialNumbersDiffer) {
  EXPECT_NE(issued(order()).serial(), issued(order()).serial());
}

TEST_F(CertificateTest, IsAcceptedByItsRealmOnly) {
  const auto certificate = issued(order());
  EXPECT_TRUE(check_issued(certificate, home_.realm.identity_ca, kNow, "x"));
  const auto foreign = check_issued(certificate, other_.realm.identity_ca, kNow, "desk.pem");
  ASSERT_FALSE(foreign);
  EXPECT_EQ(foreign.error().code, ErrorCode::kInvalid);
  EXPECT_TRUE(foreign.error().text.starts_with("desk.pem: CN=desk")) << foreign.error().text;
}

TEST_F(CertificateTest, AnAuthorityIsNoMemberAndAMemberIsNoAuthority) {
  EXPECT_FALSE(check_issued(home_.realm.identity_ca, home_.realm.identity_ca, kNow, "x"));
  EXPECT_FALSE(check_issued(home_.realm.permissions_ca, home_.realm.permissions_ca, kNow, "x"));
  const auto leaf = issued(order());
  for (const auto kind : {AuthorityKind::kIdentities, AuthorityKind::kPermissions})
    EXPECT_FALSE(check_authority(leaf, kind, kNow, "x"));
  EXPECT_TRUE(check_authority(home_.realm.identity_ca, AuthorityKind::kIdentities, kNow, "x"));
  EXPECT_TRUE(check_authority(home_.realm.permissions_ca, AuthorityKind::kPermissions, kNow, "x"));
  EXPECT_FALSE(check_authority(home_.realm.identity_ca, AuthorityKind::kPermissions, kNow, "x"));
  EXPECT_FALSE(check_authority(home_.realm.permissions_ca, AuthorityKind::kIdentities, kNow, "x"));
}

TEST_F(CertificateTest, ASubordinateOfAMemberIsRefused) {
  const auto member = issued(order("mallory"));
  const auto forged = issue(order("desk"), member, key_);
  ASSERT_TRUE(forged);
  EXPECT_FALSE(check_issued(*forged, home_.realm.identity_ca, kNow, "x"));
  const auto by_documents = issue(order("desk"), home_.realm.permissions_ca, home_.permissions_key);
  ASSERT_TRUE(by_documents);
  EXPECT_FALSE(check_issued(*by_documents, home_.realm.identity_ca, kNow, "x"));
  EXPECT_FALSE(check_issued(*by_documents, home_.realm.permissions_ca, kNow, "x"));
}

TEST_F(CertificateTest, DatesAreNamedInErrors) {
  const auto certificate = issued(order());
  const auto at = [&](int year) {
    return check_issued(certificate, home_.realm.identity_ca, std::chrono::sys_days(std::chrono::year(year) / 6 / 1),
                        "desk.pem");
  };
  EXPECT_TRUE(at(2020));
  ASSERT_FALSE(at(1970));
  EXPECT_NE(at(1970).error().text.find("the clock of this host says 1970-06-01"), std::string::npos);
  ASSERT_FALSE(at(2100));
  EXPECT_EQ(at(2100).error().code, ErrorCode::kExpired);
  EXPECT_NE(at(2100).error().text.find("CN=desk"), std::string::npos);
  EXPECT_NE(at(2100).error().text.find("ended on 2028-01-01 00:00 UTC"), std::string::npos) << at(2100).error().text;
}

TEST_F(CertificateTest, OneThatBeginsLaterIsNotValidYet) {
  const auto certificate = issued(order());
  auto* raw = X509_dup(certificate.get());
  ASSERT_NE(ASN1_TIME_set(X509_getm_notBefore(raw), 1893456000), nullptr);  // 2030
  ASSERT_GT(X509_sign(raw, home_.identity_key.get(), EVP_sha256()), 0);
  const auto early = check_issued(Certificate(CertificateHandle(raw)), home_.realm.identity_ca, kNow, "x");
  ASSERT_FALSE(early);
  EXPECT_EQ(early.error().code, ErrorCode::kExpired);
  EXPECT_NE(early.error().text.find("not valid before 2030-01-01"), std::string::npos) << early.error().text;
}

TEST_F(CertificateTest, NeverEndsAfterItsAuthority) {
  auto late = order();
  late.ends = kNow + std::chrono::days(20 * 365 * 2);
  EXPECT_EQ(issued(late).ends(), home_.realm.identity_ca.ends());
}

TEST_F(CertificateTest, AnythingButOneCertificateInPemIsRefused) {
  const auto pem = issued(order()).pem();
  for (const auto& text : {std::string(), std::string("x"), pem + pem, "# mine\n" + pem, pem + "\n",
                           pem.substr(0, pem.size() / 2), std::string(20000, 'A')}) {
    const auto read = Certificate::of_pem(text, "desk.pem");
    ASSERT_FALSE(read) << text;
    EXPECT_TRUE(read.error().text.starts_with("desk.pem: ")) << read.error().text;
  }
}

TEST(IdRanges, WrongTextsAreRefused) {
  for (const auto* text :
       {"", "7", "00000007", "00000007-00000006", "00000000-00000001", "0000000A-0000000B", "80000000-80000001",
        "00000007-00000007,", ",00000007-00000007", "00000007_00000007", "0x000007-0x000008", "+0000007-00000008"})
    EXPECT_FALSE(parse_ranges(text)) << text;
  std::string nine = "00000001-00000001";
  for (int i = 0; i < 8; ++i) nine += ",00000001-00000001";
  EXPECT_FALSE(parse_ranges(nine));
  EXPECT_TRUE(parse_ranges(nine.substr(18)));
}

TEST(IdRanges, BlocksArePatterns) {
  EXPECT_EQ(*id_pattern({7, 7}), "00000007");
  EXPECT_EQ(*id_pattern(block_range(0x1a)), "01a?????");
  EXPECT_EQ(*id_pattern(block_range(kLastBlock)), "7ff?????");
  EXPECT_FALSE(id_pattern({7, 8}));
  EXPECT_EQ(block_of(block_range(0x7ff)), 0x7ffU);
  EXPECT_EQ(block_of({0x1a00000, 0x1a0ffff}), 0U);
}

TEST(IdRanges, WrongRolesAreRefused) {
  EXPECT_EQ(*parse_roles("admin,panel"), (std::vector<std::string>{"admin", "panel"}));
  EXPECT_TRUE(parse_roles("")->empty());
  for (const auto* text : {",", "admin,", "admin,admin", "every body", "everybody", "a\nb", "-x"})
    EXPECT_FALSE(parse_roles(text)) << text;
}

TEST(MemberNames, FollowTheRule) {
  for (const auto* name : {"desk", "Robot-2", "a", "9", "wall_panel.2"}) EXPECT_TRUE(check_member_name(name)) << name;
  for (const auto* name : {"", "everybody", "peis", "all", "admin", "island:7", "..", ".x", "-x", "a/b", "a b", "a\n",
                           "a,b", "caf\xc3\xa9"})
    EXPECT_FALSE(check_member_name(name)) << name;
  EXPECT_TRUE(check_member_name(std::string(64, 'a')));
  EXPECT_FALSE(check_member_name(std::string(65, 'a')));
}

TEST(CertificateRequests, KeepTheirNameAndKey) {
  const auto key = PrivateKey::make();
  const auto pem = CertificateRequest::make("robot", *key);
  ASSERT_TRUE(pem);
  const auto read = CertificateRequest::of_pem(*pem, "x");
  ASSERT_TRUE(read) << read.error().text;
  EXPECT_EQ(read->name(), "robot");
  EXPECT_EQ(EVP_PKEY_eq(read->key(), key->get()), 1);
  EXPECT_FALSE(CertificateRequest::of_pem(*CertificateRequest::make("everybody", *key), "x"));
  auto changed = *pem;
  changed[pem->size() / 2] = changed[pem->size() / 2] == 'A' ? 'B' : 'A';
  EXPECT_FALSE(CertificateRequest::of_pem(changed, "x"));
}

}  // namespace
}  // namespace rubicon::trust
