#include "trust/signed_text.h"

#include <fmt/format.h>
#include <openssl/err.h>

#include <tuple>

namespace rubicon::trust {

namespace {

using CertificatesHandle = std::unique_ptr<STACK_OF(X509), Releaser<[](STACK_OF(X509) * some) { sk_X509_free(some); }>>;

/// Reads the signature and the content of a document.
struct Parts {
  SignedHandle signature;
  BioHandle content;
};

Parts parts_of(std::string_view document) {
  const auto bio = reading(document);
  BIO* content = nullptr;
  SignedHandle signature(SMIME_read_PKCS7(bio.get(), &content));
  return {std::move(signature), BioHandle(content)};
}

bool has_one_signature(PKCS7* signature) {
  if (PKCS7_type_is_signed(signature) == 0) return false;
  auto* signers = PKCS7_get_signer_info(signature);
  return signers != nullptr && sk_PKCS7_SIGNER_INFO_num(signers) == 1;
}

/// Otherwise PKCS7_verify() of OpenSSL 3.0 fails without giving back its memory.
bool has_known_digests(PKCS7* signature) {
  auto input = reading("");
  if (input == nullptr) return false;
  BIO* chain = PKCS7_dataInit(signature, input.get());
  if (chain == nullptr) return false;
  std::ignore = input.release();  // the end of the chain
  BIO_free_all(chain);
  return true;
}

/// Cyclone looks for the signer among the certificates of the document. A document that it cannot use must be refused
/// here, where the error names the file.
bool has_certificate_of(const Certificate& signer, PKCS7* signature) {
  const auto* certificates = signature->d.sign->cert;
  return certificates != nullptr && sk_X509_num(certificates) == 1 &&
         X509_cmp(sk_X509_value(certificates, 0), signer.get()) == 0;
}

}  // namespace

Result<std::string> sign_text(std::string_view text, const Certificate& signer, const PrivateKey& key) {
  constexpr int kFlags = PKCS7_TEXT | PKCS7_DETACHED;
  const auto content = reading(text);
  const SignedHandle signature(PKCS7_sign(signer.get(), key.get(), nullptr, content.get(), kFlags));
  const auto again = reading(text);
  const auto document = writing();
  if (signature == nullptr || document == nullptr ||
      SMIME_write_PKCS7(document.get(), signature.get(), again.get(), kFlags) != 1)
    return openssl_failed("sign a document");
  return written_text(document.get());
}

Result<std::string> verified_text(std::string_view document, const Certificate& signer, std::string_view where) {
  if (document.size() > kLargestSigned)
    return invalid_input(where, fmt::format("has more than {} bytes", kLargestSigned));
  const auto parts = parts_of(document);
  if (parts.signature == nullptr || parts.content == nullptr || !has_one_signature(parts.signature.get()))
    return invalid_input(where, "is no document with one signature (S/MIME)");
  const CertificatesHandle signers(sk_X509_new_null());
  if (signers == nullptr || sk_X509_push(signers.get(), signer.get()) <= 0) return openssl_failed("check a signature");
  const auto text = writing();
  constexpr int kFlags = PKCS7_TEXT | PKCS7_NOINTERN | PKCS7_NOVERIFY | PKCS7_NOCHAIN;
  if (!has_certificate_of(signer, parts.signature.get()) || !has_known_digests(parts.signature.get()) ||
      PKCS7_verify(parts.signature.get(), signers.get(), nullptr, parts.content.get(), text.get(), kFlags) != 1)
    return invalid_input(where, fmt::format("was not signed by {}, or was changed afterwards", signer.subject()));
  return written_text(text.get());
}

}  // namespace rubicon::trust
