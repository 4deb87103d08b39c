#include "trust/documents.h"

#include <gtest/gtest.h>
#include <openssl/pem.h>

#include "trust/bundle.h"
#include "trust/id_ranges.h"
#include "trust/now.h"
#include "trust/private_key.h"
#include "trust/revoked_list.h"
#include "trust/signed_text.h"

namespace rubicon::trust {
namespace {

const Authority& home() {
  static const auto authority = Authority::make("Rubicon", kNow);
  return *authority;
}

const Authority& other() {
  static const auto authority = Authority::make("Rubicon", kNow);
  return *authority;
}

std::string signed_by(const Authority& authority, std::string_view text) {
  return *sign_text(text, authority.realm.permissions_ca, authority.permissions_key);
}

TEST(SignedText, ComesBackFromItsSigner) {
  const auto document = signed_by(home(), "one\ntwo\n");
  const auto text = verified_text(document, home().realm.permissions_ca, "x");
  ASSERT_TRUE(text) << text.error().text;
  EXPECT_NE(text->find("one"), text->npos);
  EXPECT_NE(text->find("two"), text->npos);
}

TEST(SignedText, OfAnotherSignerIsRefused) {
  const auto document = signed_by(other(), "text");
  const auto text = verified_text(document, home().realm.permissions_ca, "governance.p7s");
  ASSERT_FALSE(text);
  EXPECT_TRUE(text.error().text.starts_with("governance.p7s: was not signed by CN=permissions")) << text.error().text;
}

TEST(SignedText, OfTheAuthorityForIdentitiesIsRefused) {
  const auto document = sign_text("text", home().realm.identity_ca, home().identity_key);
  ASSERT_TRUE(document);
  EXPECT_FALSE(verified_text(*document, home().realm.permissions_ca, "x"));
}

TEST(SignedText, OfAMemberIsRefused) {
  const auto key = PrivateKey::make();
  const CertificateOrder order{home().realm.identity().name, "mallory", {block_range(2)}, {},
                               kNow + std::chrono::days(9),  key->get()};
  const auto mallory = issue(order, home().realm.identity_ca, home().identity_key);
  ASSERT_TRUE(mallory);
  const auto document = sign_text("text", *mallory, *key);
  ASSERT_TRUE(document);
  EXPECT_FALSE(verified_text(*document, home().realm.permissions_ca, "x"));
}

TEST(SignedText, ChangedAfterwardsIsRefused) {
  const auto document = signed_by(home(), "the text that counts");
  const auto at = document.find("text that");
  ASSERT_NE(at, document.npos);
  auto changed = document;
  changed[at] = 'n';
  EXPECT_FALSE(verified_text(changed, home().realm.permissions_ca, "x"));
  EXPECT_FALSE(verified_text(document.substr(0, document.size() / 2), home().realm.permissions_ca, "x"));
  EXPECT_FALSE(verified_text("", home().realm.permissions_ca, "x"));
  EXPECT_FALSE(verified_text(std::string(kLargestSigned + 1, 'x'), home().realm.permissions_ca, "x"));
}

/// Cyclone needs it, and would refuse the document without the name of its file.
TEST(SignedText, NeedsTheCertificateOfItsSignerAndNoOther) {
  const auto& realm = home().realm;
  const auto document = [&](STACK_OF(X509) * more, int flags) {
    const auto content = reading("text"), again = reading("text");
    const auto out = writing();
    const SignedHandle signature(PKCS7_sign(realm.permissions_ca.get(), home().permissions_key.get(), more,
                                            content.get(), flags | PKCS7_TEXT | PKCS7_DETACHED));
    EXPECT_EQ(SMIME_write_PKCS7(out.get(), signature.get(), again.get(), PKCS7_TEXT | PKCS7_DETACHED), 1);
    return written_text(out.get());
  };
  auto* others = sk_X509_new_null();
  sk_X509_push(others, realm.identity_ca.get());
  EXPECT_TRUE(verified_text(document(nullptr, 0), realm.permissions_ca, "x"));
  EXPECT_FALSE(verified_text(document(others, 0), realm.permissions_ca, "x"));
  EXPECT_FALSE(verified_text(document(others, PKCS7_NOCERTS), realm.permissions_ca, "x"));
  EXPECT_FALSE(verified_text(document(nullptr, PKCS7_NOCERTS), realm.permissions_ca, "x"));
  sk_X509_free(others);
}

TEST(Documents, GovernanceEncryptsAll) {
  const auto xml = governance_xml();
  EXPECT_NE(xml.find("<allow_unauthenticated_participants>false<"), xml.npos);
  EXPECT_NE(xml.find("<topic_expression>rubicon_frames</topic_expression>"), xml.npos);
  EXPECT_NE(xml.find("<metadata_protection_kind>ENCRYPT_WITH_ORIGIN_AUTHENTICATION<"), xml.npos);
  EXPECT_EQ(xml.find("<metadata_protection_kind>NONE<"), xml.npos);
  EXPECT_EQ(xml.find('{'), xml.npos);
}

TEST(Documents, PermissionsHaveEachRangeInEachList) {
  const auto xml = permissions_xml({"home", {}, {{7, 7}, block_range(0x1a)}, {}, kNow}, "CN=home,O=R & D");
  ASSERT_TRUE(xml);
  for (const auto* part :
       {"<subject_name>CN=home,O=R &amp; D</subject_name>", "<not_after>2026-11-23T00:00:00Z</not_after>",
        "<partitions><partition>00000007</partition><partition>01a?????"
        "</partition></partitions>",
        "<partition>00000007.????????"
        "</partition><partition>01a?????.????????"
        "</partition>",
        "<partition>*.00000007</partition><partition>*.01a?????"
        "</partition>",
        "<default>DENY</default>"})
    EXPECT_NE(xml->find(part), xml->npos) << part;
  EXPECT_FALSE(permissions_xml({"home", {}, {{7, 9}}, {}, kNow}, "CN=home"));
}

TEST(Documents, TextIsEscaped) {
  EXPECT_EQ(xml_escaped("<a b=\"c\">'&"), "&lt;a b=&quot;c&quot;&gt;&apos;&amp;");
}

TEST(RevokedLists, ComeBackFromTheirSigner) {
  const RevokedList list{5, {{"0A", "desk", kNow}, {"FF00", "robot", kNow}}};
  const auto document = sign_revoked(list, home().realm.permissions_ca, home().permissions_key);
  ASSERT_TRUE(document);
  const auto read = read_revoked(*document, home().realm.permissions_ca, "x");
  ASSERT_TRUE(read) << read.error().text;
  EXPECT_EQ(*read, list);
  ASSERT_NE(read->find("FF00"), nullptr);
  EXPECT_EQ(read->find("FF"), nullptr);
  EXPECT_FALSE(read_revoked(*document, other().realm.permissions_ca, "x"));
}

TEST(RevokedLists, OfTheLargestSizeAreReadAndLargerOnesAreNotMade) {
  RevokedList list{1, {}};
  for (std::size_t i = 0; i < RevokedList::kMost; ++i)
    list.certificates.push_back({std::string(32, 'A'), std::string(64, 'n'), kNow});
  const auto document = sign_revoked(list, home().realm.permissions_ca, home().permissions_key);
  ASSERT_TRUE(document);
  const auto read = read_revoked(*document, home().realm.permissions_ca, "x");
  ASSERT_TRUE(read) << read.error().text;
  EXPECT_EQ(read->certificates.size(), RevokedList::kMost);
  list.certificates.push_back(list.certificates.front());
  EXPECT_FALSE(sign_revoked(list, home().realm.permissions_ca, home().permissions_key));
}

TEST(RevokedLists, WrongTextsAreRefused) {
  for (const auto* text :
       {"", "[]", "{}", R"({"revoked":2,"number":0,"certificates":[]})", R"({"revoked":1,"certificates":[]})",
        R"({"revoked":1,"number":-1,"certificates":[]})", R"({"revoked":1,"number":1,"certificates":[{}]})",
        R"({"revoked":1,"number":1,"certificates":[],"more":1})",
        R"({"revoked":1,"number":1,"certificates":[{"serial":"0a","name":"desk","when":1}]})",
        R"({"revoked":1,"number":1,"certificates":[{"serial":"0A","name":"../x","when":1}]})",
        R"({"revoked":1,"number":1,"certificates":[{"serial":"0A","name":"desk","when":1.5}]})",
        R"({"revoked":1,"number":1,"certificates":[{"serial":"0A","name":"desk","when":999999999999999999}]})"}) {
    const auto read = parse_revoked(text, "revoked.p7s");
    ASSERT_FALSE(read) << text;
    EXPECT_TRUE(read.error().text.starts_with("revoked.p7s: ")) << read.error().text;
  }
  EXPECT_FALSE(parse_revoked(std::string(100000, '['), "x"));
}

TEST(PrivateKeys, OpenWithTheirPhraseOnly) {
  const auto key = PrivateKey::make();
  const auto phrase = new_phrase();
  ASSERT_TRUE(phrase);
  const auto text = key->encrypted(phrase->view());
  ASSERT_TRUE(text);
  EXPECT_TRUE(text->starts_with("-----BEGIN ENCRYPTED PRIVATE KEY-----\n"));
  std::string typed(phrase->view());
  for (auto& c : typed) c = static_cast<char>(c == '-' ? ' ' : std::toupper(c));
  const auto opened = PrivateKey::decrypted(*text, typed + "\n", "x");
  ASSERT_TRUE(opened) << opened.error().text;
  EXPECT_EQ(EVP_PKEY_eq(opened->get(), key->get()), 1);
  typed[0] = typed[0] == 'A' ? 'B' : 'A';
  const auto wrong = PrivateKey::decrypted(*text, typed, "desk.trust");
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().code, ErrorCode::kRefused);
  EXPECT_TRUE(wrong.error().text.starts_with("desk.trust: the pass phrase does not open it")) << wrong.error().text;
  EXPECT_FALSE(PrivateKey::decrypted(*text, "", "x"));
}

TEST(PrivateKeys, AreNotReadFromOtherTexts) {
  const auto pem = PrivateKey::make()->pem();
  ASSERT_TRUE(pem);
  EXPECT_TRUE(PrivateKey::of_pem(pem->view(), "x"));
  for (const auto& text : {std::string(), std::string("x"), std::string(pem->view()).substr(0, 60),
                           *PrivateKey::make()->encrypted("phrase")}) {
    const auto key = PrivateKey::of_pem(text, "key.pem");
    ASSERT_FALSE(key);
    EXPECT_TRUE(key.error().text.starts_with("key.pem: ")) << key.error().text;
    EXPECT_TRUE(text.size() < 100 || key.error().text.find(text.substr(60, 20)) == text.npos);
  }
}

TEST(PrivateKeys, WithFewRoundsAreNotOpened) {
  std::unique_ptr<BIO, Releaser<BIO_free_all>> bio(BIO_new(BIO_s_mem()));
  const auto key = PrivateKey::make();
  // 2048 rounds, the number that OpenSSL takes by itself.
  ASSERT_EQ(PEM_write_bio_PKCS8PrivateKey(bio.get(), key->get(), EVP_aes_256_cbc(), "phrase", 6, nullptr, nullptr), 1);
  const auto opened = PrivateKey::decrypted(written_text(bio.get()), "phrase", "x");
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kInvalid);
}

}  // namespace
}  // namespace rubicon::trust
