#include "trust/site/site_proofs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openssl/pem.h>

#include "trust/now.h"

namespace rubicon::trust::site {
namespace {

using testing::HasSubstr;

/// An authority with a member and a broker.
class SiteCertificates : public testing::Test {
 protected:
  static PrivateKey made_key() { return std::move(*PrivateKey::make()); }
  Certificate member(const std::string& name) const {
    return *issue_member({name, ends_, member_key_.get()}, authority_, key_);
  }
  static bool has_purpose(const Certificate& certificate, int purpose) {
    return X509_check_purpose(certificate.get(), purpose, 0) == 1;
  }

  const WallTime ends_ = kNow + std::chrono::days(9);
  const PrivateKey key_ = made_key(), member_key_ = made_key();
  const Certificate authority_ = *make_site_authority("Rubicon 5f1c", ends_, key_);
  const Certificate broker_ =
      *issue_broker({"broker.test", "192.168.1.5", "fd00::1"}, {"broker", ends_, member_key_.get()}, authority_, key_);
};

TEST_F(SiteCertificates, AMemberIsNoBrokerAndABrokerIsNoMember) {
  EXPECT_TRUE(has_purpose(member("hall"), X509_PURPOSE_SSL_CLIENT));
  EXPECT_FALSE(has_purpose(member("broker.test"), X509_PURPOSE_SSL_SERVER));
  EXPECT_TRUE(has_purpose(broker_, X509_PURPOSE_SSL_SERVER));
  EXPECT_FALSE(has_purpose(broker_, X509_PURPOSE_SSL_CLIENT));
  EXPECT_FALSE(check_site_member(broker_, authority_, kNow, "input"));
  EXPECT_FALSE(check_site_member(authority_, authority_, kNow, "input"));
}

TEST_F(SiteCertificates, ABrokerHasItsNamesAndAddresses) {
  EXPECT_EQ(X509_check_host(broker_.get(), "broker.test", 0, 0, nullptr), 1);
  EXPECT_EQ(X509_check_host(broker_.get(), "other.test", 0, 0, nullptr), 0);
  EXPECT_EQ(X509_check_ip_asc(broker_.get(), "192.168.1.5", 0), 1);
  EXPECT_EQ(X509_check_ip_asc(broker_.get(), "fd00::1", 0), 1);
  EXPECT_EQ(X509_check_ip_asc(broker_.get(), "192.168.1.6", 0), 0);
}

TEST_F(SiteCertificates, AMemberIsWhomItsAuthorityNames) {
  EXPECT_EQ(*check_site_member(member("hall"), authority_, kNow, "input"), "hall");
  const auto stranger_key = made_key();
  const auto stranger = make_site_authority("Rubicon 5f1c", ends_, stranger_key);
  EXPECT_THAT(check_site_member(member("hall"), *stranger, kNow, "input").error().text,
              HasSubstr("was not certified by this realm"));
  EXPECT_EQ(check_site_member(member("hall"), authority_, ends_, "input").error().code, ErrorCode::kExpired);
  EXPECT_THAT(check_site_member(member("hall/c1"), authority_, kNow, "input").error().text, HasSubstr("another level"));
}

TEST_F(SiteCertificates, OnlyAnAuthorityIsOne) {
  EXPECT_TRUE(check_site_authority(authority_, kNow, "input"));
  EXPECT_FALSE(check_site_authority(member("hall"), kNow, "input"));
  EXPECT_FALSE(check_site_authority(broker_, kNow, "input"));
  EXPECT_EQ(check_site_authority(authority_, WallTime(), "input").error().code, ErrorCode::kExpired);
}

TEST_F(SiteCertificates, ARevocationListHoldsForTheLifeOfTheAuthority) {
  const auto hall = member("hall");
  const auto list = revocation_list({{hall.serial(), kNow}}, 7, authority_, key_, kNow);
  ASSERT_TRUE(list) << list.error().text;
  const auto bio = reading(*list);
  const std::unique_ptr<X509_CRL, Releaser<X509_CRL_free>> read(
      PEM_read_bio_X509_CRL(bio.get(), nullptr, nullptr, nullptr));
  ASSERT_NE(read, nullptr);
  EXPECT_EQ(X509_CRL_verify(read.get(), X509_get0_pubkey(authority_.get())), 1);
  X509_REVOKED* entry = nullptr;
  EXPECT_EQ(X509_CRL_get0_by_cert(read.get(), &entry, hall.get()), 1);
  EXPECT_EQ(X509_CRL_get0_by_cert(read.get(), &entry, member("lab").get()), 0);
  EXPECT_EQ(ASN1_TIME_compare(X509_CRL_get0_nextUpdate(read.get()), X509_get0_notAfter(authority_.get())), 0);
}

}  // namespace
}  // namespace rubicon::trust::site
