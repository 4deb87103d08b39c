#include "trust/guard/certificate.h"

#include <gtest/gtest.h>

#include "trust/guard/documents.h"

namespace rubicon::trust::guard {
namespace {

class CertificateTest : public testing::Test {
 protected:
  std::string pem(const Subject& subject) const { return make_member(authority_, subject).certificate_pem(); }
  std::string refusal(const Subject& subject) const { return read_certificate(pem(subject)).reason; }
  std::string refusal_of_uri(const std::string& uri) const { return refusal({.name = "desk", .uris = {uri}}); }

  Signer authority_ = make_authority("Rubicon test", Signs::Certificates);
};

TEST_F(CertificateTest, AllFieldsAreRead) {
  const auto read = read_certificate(pem({.name = "Desk_1.a-b",
                                          .uris = {"https://example.org", "rubicon:00000007-00000007,01a00000-01afffff",
                                                   "rubicon-roles:admin,night.shift"},
                                          .serial = 0xabc}));
  ASSERT_TRUE(read.certificate) << read.reason;
  EXPECT_EQ(read.certificate->name, "Desk_1.a-b");
  EXPECT_EQ(read.certificate->ids, "00000007-00000007,01a00000-01afffff");
  EXPECT_EQ(read.certificate->roles, "admin,night.shift");
  EXPECT_EQ(read.certificate->serial, "0ABC");
  EXPECT_GT(read.certificate->expires, 1'700'000'000);
  EXPECT_GE(read.certificate->prefix[0], 0x80);
}

TEST_F(CertificateTest, ThePrefixIsThatOfTheSubjectAlone) {
  const auto one = read_certificate(pem({.name = "desk", .serial = 1}));
  const auto renewed = read_certificate(pem({.name = "desk", .serial = 2}));
  const auto other = read_certificate(pem({.name = "robot", .serial = 1}));
  EXPECT_EQ(one.certificate->prefix, renewed.certificate->prefix);
  EXPECT_NE(one.certificate->prefix, other.certificate->prefix);
}

TEST_F(CertificateTest, NamesThatCouldBeMistakenAreRefused) {
  for (const std::string name : {"desk,admin", "desk admin", "desk\n", "d\xc3\xa9sk", "<desk>", ""})
    EXPECT_NE(refusal({.name = name}).find("common name"), std::string::npos) << name;
}

TEST_F(CertificateTest, MalformedIdsAreRefused) {
  for (const std::string ids :
       {"", "7", "00000007", "00000007-00000006", "00000007-00000007,", ",00000007-00000007", "0000000G-0000000H",
        "01A00000-01AFFFFF", "000000007-00000008", "00000007-00000007 ", "00000007_00000007"})
    EXPECT_EQ(refusal_of_uri("rubicon:" + ids), "its URI rubicon: is malformed") << ids;
  std::string many = "rubicon:00000000-00000000";
  while (many.size() <= 256) many += ",00000000-00000000";
  EXPECT_EQ(refusal_of_uri(many), "its URI rubicon: is malformed");
  EXPECT_EQ(refusal_of_uri(std::string("rubicon:00000007-00000007\0", 26)), "its URI rubicon: is malformed");
}

TEST_F(CertificateTest, MalformedRolesAreRefused) {
  for (const std::string roles : {"", ",", "admin,", "admin,,night", "ad min", "admin;night"})
    EXPECT_EQ(refusal_of_uri("rubicon-roles:" + roles), "its URI rubicon-roles: is malformed") << roles;
}

TEST_F(CertificateTest, TwoListsOfIdsAreRefused) {
  EXPECT_EQ(refusal({.name = "desk", .uris = {"rubicon:00000007-00000007", "rubicon:00000008-00000008"}}),
            "its URI rubicon: is malformed");
}

TEST_F(CertificateTest, WhatIsNoCertificateIsRefused) {
  const auto whole = pem({.name = "desk"});
  EXPECT_EQ(read_certificate("").reason, "its certificate cannot be read");
  EXPECT_EQ(read_certificate(whole.substr(0, whole.size() / 2)).reason, "its certificate cannot be read");
  EXPECT_EQ(read_certificate(std::string(70'000, '\n') + whole).reason, "its certificate cannot be read");
  EXPECT_EQ(read_certificate(authority_.key_pem()).reason, "its certificate cannot be read");
}

TEST_F(CertificateTest, AClaimedNameIsShownWithoutWhatCouldHarmALog) {
  EXPECT_EQ(claimed_name(pem({.name = "desk"})), "desk");
  EXPECT_EQ(claimed_name(pem({.name = "\x1b[31m evil\n"})), "??31m?evil?");
  EXPECT_EQ(claimed_name("nothing"), "");
}

TEST(PlainSerial, HasTwoUpperCaseDigitsForEachByte) {
  EXPECT_EQ(plain_serial("00abc"), "0ABC");
  EXPECT_EQ(plain_serial("1234"), "1234");
  EXPECT_EQ(plain_serial("0"), "00");
  EXPECT_EQ(plain_serial(""), "");
  EXPECT_EQ(plain_serial("12x4"), "");
  EXPECT_EQ(plain_serial(std::string(65, '1')), "");
}

}  // namespace
}  // namespace rubicon::trust::guard
