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

}  // namespace rubicon::trust
