#include <cstdlib>

#include "fuzz_target.h"
#include "trust/certificate.h"
#include "trust/id_ranges.h"

namespace rubicon::fuzz::trust_certificate_fuzz {

namespace {

using namespace rubicon::trust;

constexpr WallTime kNow = std::chrono::sys_days(std::chrono::year(2026) / 11 / 23);

const Certificate& foreign_authority() {
  static const auto key = PrivateKey::make();
  static const auto authority =
      make_authority(AuthorityKind::kIdentities, "Fuzz 0000", kNow + std::chrono::days(1000), *key);
  return *authority;
}

void read(const Certificate& certificate) {
  (void)certificate.subject();
  (void)certificate.serial();
  if (check_issued(certificate, foreign_authority(), kNow, "input")) std::abort();
  (void)check_authority(certificate, AuthorityKind::kIdentities, kNow, "input");
  (void)check_authority(certificate, AuthorityKind::kPermissions, kNow, "input");
  const auto member = certificate.member("input");
  if (!member && member.error().text.empty()) std::abort();
  if (!member) return;
  const auto ids = parse_ranges(ranges_text(member->ids));
  const auto roles = parse_roles(roles_text(member->roles));
  if (!ids || *ids != member->ids || !roles || *roles != member->roles) std::abort();
}

}  // namespace

/// Input: a certificate in DER, or in PEM.
FUZZ_TARGET(trust_certificate) {
  const auto* at = data;
  CertificateHandle raw(d2i_X509(nullptr, &at, static_cast<long>(size)));
  if (raw != nullptr) {
    const Certificate certificate(std::move(raw));
    read(certificate);
    (void)Certificate::of_pem(certificate.pem(), "input");
  }
  const auto certificate = Certificate::of_pem({reinterpret_cast<const char*>(data), size}, "input");
  if (certificate) read(*certificate);
  return 0;
}

}  // namespace rubicon::fuzz::trust_certificate_fuzz
