#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"
#include "rubicon/time.hpp"
#include "trust/openssl_handles.h"
#include "trust/private_key.h"
#include "tuples/member.h"

namespace rubicon::trust {

inline constexpr std::size_t kLargestCertificate = 16384;  ///< bytes of PEM

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
  /// The member that it names: CN, the ids and the roles of the subject's alternative names (`URI:rubicon:<ranges>`,
  /// `URI:rubicon-roles:<roles>`). Errors begin with `where`.
  Result<tuples::Member> member(std::string_view where) const;
  /// Whether the key is that of the certificate.
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
/// Whether the authority issued this member's certificate, for TLS client and server, and both are valid now.
Result<void> check_issued(const Certificate& certificate, const Certificate& authority, WallTime now,
                          std::string_view where);

/// A certificate to be made.
struct CertificateOrder {
  std::string organisation, name;
  std::vector<tuples::IdRange> ids;
  std::vector<std::string> roles;
  WallTime ends{};
  EVP_PKEY* key = nullptr;  ///< only its public part is used
};
/// Begins in 2020, so that hosts whose clock is behind can start.
Result<Certificate> issue(const CertificateOrder& order, const Certificate& authority, const PrivateKey& key);

/// What an authority signs.
enum class AuthorityKind { kIdentities, kPermissions };
/// A certificate that its own key signs.
Result<Certificate> make_authority(AuthorityKind kind, const std::string& organisation, WallTime ends,
                                   const PrivateKey& key);
/// Whether a certificate is one as make_authority() makes, and valid now.
Result<void> check_authority(const Certificate& certificate, AuthorityKind kind, WallTime now, std::string_view where);

}  // namespace rubicon::trust
