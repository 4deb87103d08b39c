#pragma once

#include <string>
#include <vector>

#include "trust/certificate.h"

namespace rubicon::trust::site {

// Certificates of the realm of brokers (X.509, RFC 5280): one authority; members prove themselves as TLS clients only,
// brokers as TLS servers only, so that no member can pose as the broker.

/// For certificates, revocation lists and realm files.
Result<Certificate> make_site_authority(const std::string& realm, WallTime ends, const PrivateKey& key);
/// Whether a certificate is one as make_site_authority() makes, and valid now.
Result<void> check_site_authority(const Certificate& certificate, WallTime now, std::string_view where);

struct SiteOrder {
  std::string name;  ///< the MQTT user (CN)
  WallTime ends{};   ///< never longer than the authority
  EVP_PKEY* key = nullptr;
};
Result<Certificate> issue_member(const SiteOrder& order, const Certificate& authority, const PrivateKey& key);
/// `hosts`: names or addresses of the broker as clients spell them, for the alternative names.
Result<Certificate> issue_broker(const std::vector<std::string>& hosts, const SiteOrder& order,
                                 const Certificate& authority, const PrivateKey& key);
/// Whether the authority issued the certificate of a member, and both are valid now; its name.
Result<std::string> check_site_member(const Certificate& certificate, const Certificate& authority, WallTime now,
                                      std::string_view where);

struct RevokedSerial {
  std::string serial;  ///< upper-case hexadecimal digits
  WallTime when{};
};
/// A revocation list in PEM, for as long as the authority lives: brokers refuse everybody after the end of a list.
Result<std::string> revocation_list(const std::vector<RevokedSerial>& revoked, std::uint64_t number,
                                    const Certificate& authority, const PrivateKey& key, WallTime now);

}  // namespace rubicon::trust::site
