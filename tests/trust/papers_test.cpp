#include <gtest/gtest.h>
#include <openssl/pem.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "trust/certificate.h"
#include "trust/member_names.h"
#include "trust/now.h"
#include "trust/private_key.h"
#include "trust/secret_text.h"
#include "trust/site/site_proofs.h"

namespace rubicon::trust {
namespace {

/// An authority with its key.
struct Signer {
  PrivateKey key = *PrivateKey::make();
  Certificate certificate = *site::make_site_authority("Rubicon 5f1c", kNow + std::chrono::days(9000), key);

  std::string sign(std::string_view text) const { return *sign_text(text, certificate, key); }
};

const Signer& home() {
  static const Signer one;
  return one;
}

TEST(SignedText, ComesBackFromItsSigner) {
  const auto text = verified_text(home().sign("one\ntwo\n"), home().certificate, "x");
  ASSERT_TRUE(text) << text.error().text;
  EXPECT_NE(text->find("one"), text->npos);
  EXPECT_NE(text->find("two"), text->npos);
}

TEST(SignedText, OfAnotherSignerIsRefused) {
  const auto text = verified_text(Signer().sign("text"), home().certificate, "realm.p7s");
  ASSERT_FALSE(text);
  EXPECT_TRUE(text.error().text.starts_with("realm.p7s: was not signed by CN=authority")) << text.error().text;
}

TEST(SignedText, OfAMemberIsRefused) {
  const auto key = PrivateKey::make();
  const auto mallory =
      site::issue_member({"mallory", kNow + std::chrono::days(9), key->get()}, home().certificate, home().key);
  ASSERT_TRUE(mallory);
  const auto document = sign_text("text", *mallory, *key);
  ASSERT_TRUE(document);
  EXPECT_FALSE(verified_text(*document, home().certificate, "x"));
}

TEST(SignedText, ChangedAfterwardsIsRefused) {
  const auto document = home().sign("the text that counts");
  const auto at = document.find("text that");
  ASSERT_NE(at, document.npos);
  auto changed = document;
  changed[at] = 'n';
  for (const auto& text :
       {changed, document.substr(0, document.size() / 2), std::string(), std::string(kMaxSigned + 1, 'x')})
    EXPECT_FALSE(verified_text(text, home().certificate, "x"));
}

TEST(SignedText, NeedsTheCertificateOfItsSignerAndNoOther) {
  const Signer other;
  const auto document = [&](STACK_OF(X509) * more, int flags) {
    const auto content = reading("text"), again = reading("text");
    const auto out = writing();
    const SignedHandle signature(PKCS7_sign(home().certificate.get(), home().key.get(), more, content.get(),
                                            flags | PKCS7_TEXT | PKCS7_DETACHED));
    EXPECT_EQ(SMIME_write_PKCS7(out.get(), signature.get(), again.get(), PKCS7_TEXT | PKCS7_DETACHED), 1);
    return written_text(out.get());
  };
  auto* others = sk_X509_new_null();
  sk_X509_push(others, other.certificate.get());
  EXPECT_TRUE(verified_text(document(nullptr, 0), home().certificate, "x"));
  EXPECT_FALSE(verified_text(document(others, 0), home().certificate, "x"));
  EXPECT_FALSE(verified_text(document(others, PKCS7_NOCERTS), home().certificate, "x"));
  EXPECT_FALSE(verified_text(document(nullptr, PKCS7_NOCERTS), home().certificate, "x"));
  sk_X509_free(others);
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

TEST(MemberNames, WrongRolesAreRefused) {
  EXPECT_EQ(*parse_roles("admin,panel"), (std::vector<std::string>{"admin", "panel"}));
  EXPECT_TRUE(parse_roles("")->empty());
  for (const auto* text : {",", "admin,", "admin,admin", "every body", "everybody", "lan", "a\nb", "-x"})
    EXPECT_FALSE(parse_roles(text)) << text;
}

TEST(MemberNames, FollowTheRule) {
  for (const auto* name : {"desk", "Robot-2", "a", "9", "wall_panel.2"}) EXPECT_TRUE(check_member_name(name)) << name;
  for (const auto* name : {"", "everybody", "peis", "lan", "all", "admin", "island:7", "..", ".x", "-x", "a/b", "a b",
                           "a\n", "a,b", "caf\xc3\xa9"})
    EXPECT_FALSE(check_member_name(name)) << name;
  EXPECT_TRUE(check_member_name(std::string(64, 'a')));
  EXPECT_FALSE(check_member_name(std::string(65, 'a')));
}

TEST(PrivateMemory, IsNotWrittenToACoreFile) {
  const auto child = ::fork();
  if (child == 0) {
    keep_memory_private();
    rlimit core{1, 1};
    const bool none = ::getrlimit(RLIMIT_CORE, &core) == 0 && core.rlim_cur == 0 && core.rlim_max == 0;
    ::_exit(none && ::prctl(PR_GET_DUMPABLE) == 0 ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
}

}  // namespace
}  // namespace rubicon::trust
