#pragma once

#include <openssl/bio.h>
#include <openssl/bn.h>
#include <openssl/evp.h>
#include <openssl/pkcs7.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include <memory>
#include <string>
#include <string_view>

#include "rubicon/result.hpp"
#include "trust/secret_text.h"

namespace rubicon::trust {

template <auto Release>
struct Releaser {
  template <class T>
  void operator()(T* object) const {
    Release(object);
  }
};

using BioHandle = std::unique_ptr<BIO, Releaser<BIO_free_all>>;
using KeyHandle = std::unique_ptr<EVP_PKEY, Releaser<EVP_PKEY_free>>;
using KeyContextHandle = std::unique_ptr<EVP_PKEY_CTX, Releaser<EVP_PKEY_CTX_free>>;
using CertificateHandle = std::unique_ptr<X509, Releaser<X509_free>>;
using SignedHandle = std::unique_ptr<PKCS7, Releaser<PKCS7_free>>;
using NumberHandle = std::unique_ptr<BIGNUM, Releaser<BN_free>>;

/// A BIO that reads the text, which must outlive it.
BioHandle reading(std::string_view text);
/// A BIO that keeps what is written.
BioHandle writing();
std::string written_text(BIO* bio);

/// `OpenSSL cannot <operation>: <reason>`; its queue of errors is empty afterwards.
tl::unexpected<Error> openssl_failed(std::string_view operation);
/// kInvalid, `<where>: <what>`, with the reason of OpenSSL if it gave one.
tl::unexpected<Error> invalid_input(std::string_view where, std::string_view what);

/// A key pair on the curve P-256.
class PrivateKey {
 public:
  static Result<PrivateKey> make();
  /// A key in PEM (PKCS 8) without a pass phrase, with a private part that fits the public one. `where` names the
  /// source in errors.
  static Result<PrivateKey> of_pem(std::string_view pem, std::string_view where);
  /// A key in PEM that a pass phrase protects, as encrypted() writes it. The phrase is as it was typed
  /// (plain_phrase()). kRefused: wrong phrase. Other protections, and rounds that would take minutes, are kInvalid.
  static Result<PrivateKey> decrypted(std::string_view pem, std::string_view phrase, std::string_view where);

  Result<SecretText> pem() const;
  /// PKCS 8 with PBES2: PBKDF2 of HMAC-SHA-256 with kRounds, AES-256-CBC.
  Result<std::string> encrypted(std::string_view phrase) const;

  EVP_PKEY* get() const { return key_.get(); }

  static constexpr int kRounds = 600000;
  static constexpr int kMaxRoundCount = 10000000;

 private:
  explicit PrivateKey(KeyHandle key) : key_(std::move(key)) {}
  KeyHandle key_;
};

/// A new pass phrase: 6 groups of 4 letters and digits that are not mistaken for each other, 120 random bits.
Result<SecretText> new_phrase();
/// What counts of a phrase that a person types: without blanks and `-`, in lower case.
SecretText plain_phrase(std::string_view typed);

/// Whether the key has the curve that the realm uses.
bool is_p256(const EVP_PKEY* key);

}  // namespace rubicon::trust
