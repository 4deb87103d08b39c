#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"
#include "trust/certificate.h"
#include "trust/secret_text.h"

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

/// A password as mosquitto 2 keeps it: PBKDF2 with HMAC-SHA-512, `$7$<rounds>$<salt>$<hash>` (mosquitto_passwd(1)).
/// The passwords are random and of 120 bits: few rounds do.
Result<std::string> password_hash(std::string_view password);
/// Whether it is the password of that hash; false for what is no such hash.
bool is_password_of(std::string_view password, std::string_view hash);
/// A phrase as it was shown, whatever blanks and capitals it was typed with: in groups of 4 with `-`.
SecretText spelled_phrase(std::string_view typed);

/// The lines of a password file of mosquitto: hashes by user.
using PasswordLines = std::map<std::string, std::string, std::less<>>;
/// kInvalid: a user whose name is not a level of a topic (check_user_name()), or a line without a hash.
Result<PasswordLines> parse_passwords(std::string_view text, std::string_view where);
std::string passwords_text(const PasswordLines& lines);

}  // namespace rubicon::trust::site
