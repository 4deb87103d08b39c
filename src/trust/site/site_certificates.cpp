#include "trust/site/site_certificates.h"

#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/pem.h>

#include <algorithm>
#include <cstring>
#include <ctime>

#include "trust/certificate.h"
#include "trust/site/user_names.h"

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

}  // namespace rubicon::trust::site
