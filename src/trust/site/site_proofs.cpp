#include "trust/site/site_proofs.h"

#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <ctime>
#include <optional>

#include "base/text.h"
#include "trust/certificate.h"
#include "trust/private_key.h"
#include "trust/site/site_identity.h"

namespace rubicon::trust::site {

namespace {

constexpr std::uint32_t kAuthorityUsage = KU_KEY_CERT_SIGN | KU_CRL_SIGN | KU_DIGITAL_SIGNATURE;

using StoreHandle = std::unique_ptr<X509_STORE, Releaser<X509_STORE_free>>;
using StoreContextHandle = std::unique_ptr<X509_STORE_CTX, Releaser<X509_STORE_CTX_free>>;

/// nullptr if the chain holds for a TLS client, else the reason.
const char* fault_of_client(const Certificate& certificate, const Certificate& authority, WallTime now) {
  const StoreHandle store(X509_STORE_new());
  const StoreContextHandle context(X509_STORE_CTX_new());
  if (store == nullptr || context == nullptr || X509_STORE_add_cert(store.get(), authority.get()) != 1 ||
      X509_STORE_CTX_init(context.get(), store.get(), certificate.get(), nullptr) != 1)
    return "OpenSSL cannot check it";
  auto* parameters = X509_STORE_CTX_get0_param(context.get());
  X509_VERIFY_PARAM_set_time(parameters, std::chrono::system_clock::to_time_t(now));
  X509_VERIFY_PARAM_set_flags(parameters, X509_V_FLAG_CHECK_SS_SIGNATURE | X509_V_FLAG_X509_STRICT);
  X509_STORE_CTX_set_purpose(context.get(), X509_PURPOSE_SSL_CLIENT);
  const bool good = X509_verify_cert(context.get()) == 1;
  ERR_clear_error();
  return good ? nullptr : X509_verify_cert_error_string(X509_STORE_CTX_get_error(context.get()));
}

/// An address if the text is one, else a DNS name.
GENERAL_NAME* alternative_of(const std::string& host) {
  auto* name = GENERAL_NAME_new();
  if (name == nullptr) return nullptr;
  if (auto* address = a2i_IPADDRESS(host.c_str()); address != nullptr) {
    GENERAL_NAME_set0_value(name, GEN_IPADD, address);
    return name;
  }
  ERR_clear_error();
  auto* text = ASN1_IA5STRING_new();
  if (text == nullptr || ASN1_STRING_set(text, host.data(), static_cast<int>(host.size())) != 1) {
    ASN1_IA5STRING_free(text);
    GENERAL_NAME_free(name);
    return nullptr;
  }
  GENERAL_NAME_set0_value(name, GEN_DNS, text);
  return name;
}

bool add_hosts(X509* certificate, const std::vector<std::string>& hosts) {
  const AlternativeNames names(sk_GENERAL_NAME_new_null());
  if (names == nullptr) return false;
  for (const auto& host : hosts) {
    auto* name = alternative_of(host);
    if (name == nullptr) return false;
    if (sk_GENERAL_NAME_push(names.get(), name) > 0) continue;
    GENERAL_NAME_free(name);
    return false;
  }
  return X509_add1_ext_i2d(certificate, NID_subject_alt_name, names.get(), 0, X509V3_ADD_DEFAULT) == 1;
}

CertificateHandle begin_leaf(const SiteOrder& order, const Certificate& authority, const char* usage) {
  auto made =
      begin_certificate(authority.organisation(), order.name, std::min(order.ends, authority.ends()), order.key);
  if (made == nullptr || !add_extension(made.get(), authority.get(), NID_basic_constraints, "critical,CA:FALSE") ||
      !add_extension(made.get(), authority.get(), NID_key_usage, "critical,digitalSignature") ||
      !add_extension(made.get(), authority.get(), NID_ext_key_usage, usage))
    return nullptr;
  return made;
}

}  // namespace

Result<Certificate> make_site_authority(const std::string& realm, WallTime ends, const PrivateKey& key) {
  auto made = begin_certificate(realm, "authority", ends, key.get());
  auto* raw = made.get();
  const bool good = raw != nullptr && X509_set_issuer_name(raw, X509_get_subject_name(raw)) == 1 &&
                    add_extension(raw, raw, NID_basic_constraints, "critical,CA:TRUE,pathlen:0") &&
                    add_extension(raw, raw, NID_key_usage, "critical,keyCertSign,cRLSign,digitalSignature") &&
                    finish_certificate(raw, raw, key);
  if (!good) return openssl_failed("make an authority");
  return read_again(std::move(made), "the new authority");
}

Result<void> check_site_authority(const Certificate& certificate, WallTime now, std::string_view where) {
  if (auto dated = check_dates(certificate, now, where); !dated) return dated;
  auto* raw = certificate.get();
  const auto flags = X509_get_extension_flags(raw);
  const bool is_authority = (flags & (EXFLAG_INVALID | EXFLAG_CRITICAL)) == 0 && (flags & EXFLAG_CA) != 0 &&
                            X509_get_key_usage(raw) == kAuthorityUsage;
  const bool signed_by_itself = X509_self_signed(raw, 1) == 1;
  ERR_clear_error();
  if (is_authority && signed_by_itself && is_p256(X509_get0_pubkey(raw)) && !certificate.organisation().empty())
    return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("{}: {} is not the authority of a realm of brokers", where, certificate.subject()));
}

Result<Certificate> issue_member(const SiteOrder& order, const Certificate& authority, const PrivateKey& key) {
  auto made = begin_leaf(order, authority, "clientAuth");
  if (made == nullptr || !finish_certificate(made.get(), authority.get(), key))
    return openssl_failed(fmt::format("make the certificate of {}", order.name));
  return read_again(std::move(made), order.name);
}

Result<Certificate> issue_broker(const std::vector<std::string>& hosts, const SiteOrder& order,
                                 const Certificate& authority, const PrivateKey& key) {
  auto made = begin_leaf(order, authority, "serverAuth");
  if (made == nullptr || !add_hosts(made.get(), hosts) || !finish_certificate(made.get(), authority.get(), key))
    return openssl_failed("make the certificate of a broker");
  return read_again(std::move(made), "the certificate of the broker");
}

Result<std::string> check_site_member(const Certificate& certificate, const Certificate& authority, WallTime now,
                                      std::string_view where) {
  if (auto dated = check_dates(certificate, now, where); !dated) return fail(dated.error());
  if (const auto* fault = fault_of_client(certificate, authority, now); fault != nullptr)
    return fail(ErrorCode::kInvalid, fmt::format("{}: {} was not certified by this realm ({}): {}", where,
                                                 certificate.subject(), authority.organisation(), fault));
  auto* raw = certificate.get();
  if (X509_get_extended_key_usage(raw) != XKU_SSL_CLIENT || (X509_get_extension_flags(raw) & EXFLAG_CA) != 0 ||
      certificate.organisation() != authority.organisation())
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: {} is not the certificate of a member: expected one for TLS clients", where,
                            certificate.subject()));
  auto name = certificate.common_name();
  if (auto checked = check_user_name(name); !checked) return invalid_input(where, checked.error().text);
  return name;
}

namespace {

using ListHandle = std::unique_ptr<X509_CRL, Releaser<X509_CRL_free>>;
using EntryHandle = std::unique_ptr<X509_REVOKED, Releaser<X509_REVOKED_free>>;
using TimeHandle = std::unique_ptr<ASN1_TIME, Releaser<ASN1_TIME_free>>;
using SerialHandle = std::unique_ptr<ASN1_INTEGER, Releaser<ASN1_INTEGER_free>>;

constexpr long kListVersion2 = 1;
/// A broker whose clock is behind must not refuse everybody because of a list that is still to come.
constexpr auto kClockError = std::chrono::hours(24);

TimeHandle time_of(WallTime time) {
  return TimeHandle(ASN1_TIME_set(nullptr, std::chrono::system_clock::to_time_t(time)));
}

bool add_entry(X509_CRL* list, const RevokedSerial& one) {
  BIGNUM* digits = nullptr;
  if (BN_hex2bn(&digits, one.serial.c_str()) == 0) return false;
  const NumberHandle number(digits);
  const SerialHandle serial(BN_to_ASN1_INTEGER(number.get(), nullptr));
  EntryHandle entry(X509_REVOKED_new());
  const auto when = time_of(one.when);
  if (serial == nullptr || entry == nullptr || when == nullptr ||
      X509_REVOKED_set_serialNumber(entry.get(), serial.get()) != 1 ||
      X509_REVOKED_set_revocationDate(entry.get(), when.get()) != 1 || X509_CRL_add0_revoked(list, entry.get()) != 1)
    return false;
  std::ignore = entry.release();
  return true;
}

bool add_list_number(X509_CRL* list, std::uint64_t number) {
  const SerialHandle value(ASN1_INTEGER_new());
  return value != nullptr && ASN1_INTEGER_set_uint64(value.get(), number) == 1 &&
         X509_CRL_add1_ext_i2d(list, NID_crl_number, value.get(), 0, 0) == 1;
}

bool add_key_identifier(X509_CRL* list, X509* issuer) {
  X509V3_CTX context{};
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, issuer, nullptr, nullptr, list, 0);
  auto* extension = X509V3_EXT_conf_nid(nullptr, &context, NID_authority_key_identifier, "keyid:always");
  const bool added = extension != nullptr && X509_CRL_add_ext(list, extension, -1) == 1;
  X509_EXTENSION_free(extension);
  return added;
}

}  // namespace

Result<std::string> revocation_list(const std::vector<RevokedSerial>& revoked, std::uint64_t number,
                                    const Certificate& authority, const PrivateKey& key, WallTime now) {
  const ListHandle list(X509_CRL_new());
  const auto begins = time_of(std::max(authority.begins(), now - kClockError)), ends = time_of(authority.ends());
  const auto made = [&] {
    if (list == nullptr || begins == nullptr || ends == nullptr || X509_CRL_set_version(list.get(), kListVersion2) != 1)
      return false;
    if (X509_CRL_set_issuer_name(list.get(), X509_get_subject_name(authority.get())) != 1 ||
        X509_CRL_set1_lastUpdate(list.get(), begins.get()) != 1 ||
        X509_CRL_set1_nextUpdate(list.get(), ends.get()) != 1)
      return false;
    return std::all_of(revoked.begin(), revoked.end(), [&](const auto& one) { return add_entry(list.get(), one); }) &&
           add_key_identifier(list.get(), authority.get()) && add_list_number(list.get(), number) &&
           X509_CRL_sort(list.get()) == 1 && X509_CRL_sign(list.get(), key.get(), EVP_sha256()) > 0;
  };
  const auto bio = writing();
  if (!made() || bio == nullptr || PEM_write_bio_X509_CRL(bio.get(), list.get()) != 1)
    return openssl_failed("make a revocation list");
  return written_text(bio.get());
}

namespace {

constexpr int kPasswordRounds = 101;  // what mosquitto_passwd takes
constexpr int kMaxPasswordRounds = 10'000'000;
constexpr std::size_t kSaltSize = 12, kHashSize = 64;
constexpr std::string_view kHashForm = "$7$";
constexpr std::size_t kPhraseGroup = 4;

std::string base64(const unsigned char* bytes, std::size_t size) {
  std::string text(4 * ((size + 2) / 3) + 1, '\0');
  const int written = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), bytes, static_cast<int>(size));
  text.resize(static_cast<std::size_t>(std::max(written, 0)));
  return text;
}

std::optional<std::array<unsigned char, kSaltSize>> salt_in(std::string_view text) {
  std::array<unsigned char, kSaltSize> salt{};
  if (text.size() != 4 * kSaltSize / 3) return {};
  const int size =
      EVP_DecodeBlock(salt.data(), reinterpret_cast<const unsigned char*>(text.data()), static_cast<int>(text.size()));
  return size == static_cast<int>(kSaltSize) ? std::optional(salt) : std::nullopt;
}

std::string hash_of(std::string_view password, const std::array<unsigned char, kSaltSize>& salt, int rounds) {
  std::array<unsigned char, kHashSize> hash{};
  if (PKCS5_PBKDF2_HMAC(password.data(), static_cast<int>(password.size()), salt.data(), static_cast<int>(salt.size()),
                        rounds, EVP_sha512(), static_cast<int>(hash.size()), hash.data()) != 1)
    return {};
  return fmt::format("{}{}${}${}", kHashForm, rounds, base64(salt.data(), salt.size()),
                     base64(hash.data(), hash.size()));
}

}  // namespace

Result<std::string> password_hash(std::string_view password) {
  std::array<unsigned char, kSaltSize> salt{};
  if (RAND_bytes(salt.data(), static_cast<int>(salt.size())) != 1) return openssl_failed("make a password");
  auto hash = hash_of(password, salt, kPasswordRounds);
  if (hash.empty()) return openssl_failed("keep a password");
  return hash;
}

bool is_password_of(std::string_view password, std::string_view hash) {
  if (!hash.starts_with(kHashForm)) return false;
  const auto rest = hash.substr(kHashForm.size());
  const auto first = rest.find('$'), second = first == rest.npos ? first : rest.find('$', first + 1);
  if (second == rest.npos) return false;
  const auto rounds = base::parse_number<int>(rest.substr(0, first));
  const auto salt = salt_in(rest.substr(first + 1, second - first - 1));
  return rounds && *rounds > 0 && *rounds <= kMaxPasswordRounds && salt && hash_of(password, *salt, *rounds) == hash;
}

SecretText spelled_phrase(std::string_view typed) {
  const auto plain = plain_phrase(typed);
  std::string spelled;
  spelled.reserve(2 * plain.view().size());
  for (std::size_t i = 0; i < plain.view().size(); ++i) {
    if (i > 0 && i % kPhraseGroup == 0) spelled += '-';
    spelled += plain.view()[i];
  }
  return SecretText(std::move(spelled));
}

Result<PasswordLines> parse_passwords(std::string_view text, std::string_view where) {
  PasswordLines lines;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const auto end = text.find('\n');
    const auto line = base::trimmed(text.substr(0, end));
    text.remove_prefix(end == text.npos ? text.size() : end + 1);
    if (line.empty() || line.starts_with('#')) continue;
    const auto colon = line.find(':');
    const auto user = line.substr(0, colon);
    if (auto checked = check_user_name(user); !checked)
      return fail(ErrorCode::kInvalid, fmt::format("{}:{}: {}", where, number, checked.error().text));
    if (colon == line.npos || !line.substr(colon + 1).starts_with('$'))
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}:{}: expected {}:$7$..., as mosquitto_passwd writes it", where, number, user));
    lines[std::string(user)] = line.substr(colon + 1);
  }
  return lines;
}

std::string passwords_text(const PasswordLines& lines) {
  std::string text;
  for (const auto& [user, hash] : lines) text += user + ":" + hash + "\n";
  return text;
}

}  // namespace rubicon::trust::site
