#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "rubicon/result.hpp"
#include "rubicon/time.hpp"
#include "trust/private_key.h"

namespace rubicon::trust {

inline constexpr std::size_t kMaxCertificate = 16384;  ///< bytes of PEM

/// A certificate (X.509), never changed. Cheap to copy.
class Certificate {
 public:
  /// One certificate in PEM as OpenSSL writes it, and nothing else. `where` names the source in errors.
  static Result<Certificate> of_pem(std::string_view pem, std::string_view where);
  explicit Certificate(CertificateHandle certificate) : certificate_(std::move(certificate)) {}

  std::string pem() const;
  /// RFC 2253: `CN=desk,O=Rubicon 5f1c`.
  std::string subject() const;
  /// The organisation of the subject: the realm. Empty if it has none, or several.
  std::string organisation() const;
  /// The common name (CN) of the subject as it is. Empty if it has none, or several.
  std::string common_name() const;
  WallTime begins() const;
  WallTime ends() const;
  /// Upper-case hexadecimal digits.
  std::string serial() const;
  /// Whether the key belongs to the certificate.
  bool has_key(const EVP_PKEY* key) const;

  X509* get() const { return certificate_.get(); }
  friend bool operator==(const Certificate& left, const Certificate& right);

 private:
  std::shared_ptr<X509> certificate_;
};

/// `2028-01-01 00:00 UTC`.
std::string date_text(WallTime time);
/// kExpired if the clock says a time before 2020, when the first certificates begin.
Result<void> check_clock(WallTime now, std::string_view where);
/// kExpired unless the certificate is valid now; the text has its name and the dates.
Result<void> check_dates(const Certificate& certificate, WallTime now, std::string_view where);

// What all certificates of our authorities have in common.

using AlternativeNames = std::unique_ptr<GENERAL_NAMES, Releaser<GENERAL_NAMES_free>>;

/// All but the extensions and the signature: O and CN, a random serial number, from 2020 until `ends`. Empty: OpenSSL
/// failed.
CertificateHandle begin_certificate(const std::string& organisation, const std::string& name, WallTime ends,
                                    EVP_PKEY* key);
/// By number and text, as the configuration of OpenSSL spells it.
bool add_extension(X509* certificate, X509* issuer, int nid, const char* text);
/// Key identifiers and the signature.
bool finish_certificate(X509* certificate, X509* issuer, const PrivateKey& key);
/// The same certificate without what OpenSSL remembers of its extensions from before they were complete.
Result<Certificate> read_again(CertificateHandle made, std::string_view what);

/// The certificate in DER.
std::string der_of(const Certificate& certificate);

/// Bytes of the largest signed text, with its signature.
inline constexpr std::size_t kMaxSigned = 1U << 20U;

/// Signs a text as S/MIME with a detached signature, the form that DDS Security 1.1, section 9.4.1 asks for.
Result<std::string> sign_text(std::string_view text, const Certificate& signer, const PrivateKey& key);

/// The text, if exactly this certificate's key signed it, and the document has this certificate and no other. The dates
/// of the signer are the caller's to check. `where` names the source in errors.
Result<std::string> verified_text(std::string_view document, const Certificate& signer, std::string_view where);

}  // namespace rubicon::trust
