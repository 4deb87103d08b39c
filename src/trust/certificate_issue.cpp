#include <fmt/format.h>
#include <openssl/rand.h>

#include <array>

#include "trust/certificate.h"
#include "trust/certificate_parts.h"
#include "trust/id_ranges.h"

namespace rubicon::trust {

namespace {

constexpr std::time_t kBegin = 1577836800;  // 2020-01-01 00:00 UTC
constexpr long kVersion3 = 2;

bool set_subject(X509_NAME* name, const std::string& organisation, const std::string& common) {
  const auto add = [name](const char* field, const std::string& text) {
    return X509_NAME_add_entry_by_txt(name, field, MBSTRING_UTF8, reinterpret_cast<const unsigned char*>(text.data()),
                                      static_cast<int>(text.size()), -1, 0) == 1;
  };
  return add("O", organisation) && add("CN", common);
}

/// 127 random bits of which the first is set: always 32 hexadecimal digits.
bool set_serial(X509* certificate) {
  std::array<unsigned char, 16> random{};
  if (RAND_bytes(random.data(), static_cast<int>(random.size())) != 1) return false;
  random[0] = static_cast<unsigned char>((random[0] & 0x7fU) | 0x40U);
  const NumberHandle number(BN_bin2bn(random.data(), static_cast<int>(random.size()), nullptr));
  return number != nullptr && BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(certificate)) != nullptr;
}

bool set_dates(X509* certificate, WallTime ends) {
  const auto last = std::chrono::duration_cast<std::chrono::seconds>(ends.time_since_epoch()).count();
  return ASN1_TIME_set(X509_getm_notBefore(certificate), kBegin) != nullptr &&
         ASN1_TIME_set(X509_getm_notAfter(certificate), last) != nullptr;
}

bool add_uri(GENERAL_NAMES* names, const std::string& text) {
  auto* name = GENERAL_NAME_new();
  auto* uri = ASN1_IA5STRING_new();
  if (name == nullptr || uri == nullptr || ASN1_STRING_set(uri, text.data(), static_cast<int>(text.size())) != 1) {
    GENERAL_NAME_free(name);
    ASN1_IA5STRING_free(uri);
    return false;
  }
  GENERAL_NAME_set0_value(name, GEN_URI, uri);
  if (sk_GENERAL_NAME_push(names, name) > 0) return true;
  GENERAL_NAME_free(name);
  return false;
}

/// The configuration syntax of OpenSSL cannot spell a comma in a name.
bool add_alternative_names(X509* certificate, const CertificateOrder& order) {
  const AlternativeNames names(sk_GENERAL_NAME_new_null());
  if (names == nullptr || !add_uri(names.get(), "rubicon:" + ranges_text(order.ids))) return false;
  if (!order.roles.empty() && !add_uri(names.get(), "rubicon-roles:" + roles_text(order.roles))) return false;
  return X509_add1_ext_i2d(certificate, NID_subject_alt_name, names.get(), 0, X509V3_ADD_DEFAULT) == 1;
}

}  // namespace

CertificateHandle begin_certificate(const std::string& organisation, const std::string& name, WallTime ends,
                                    EVP_PKEY* key) {
  CertificateHandle made(X509_new());
  const bool good = made != nullptr && X509_set_version(made.get(), kVersion3) == 1 && set_serial(made.get()) &&
                    set_subject(X509_get_subject_name(made.get()), organisation, name) && set_dates(made.get(), ends) &&
                    X509_set_pubkey(made.get(), key) == 1;
  return good ? std::move(made) : nullptr;
}

bool add_extension(X509* certificate, X509* issuer, int nid, const char* text) {
  X509V3_CTX context{};
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  auto* extension = X509V3_EXT_conf_nid(nullptr, &context, nid, text);
  const bool added = extension != nullptr && X509_add_ext(certificate, extension, -1) == 1;
  X509_EXTENSION_free(extension);
  return added;
}

bool finish_certificate(X509* certificate, X509* issuer, const PrivateKey& key) {
  return X509_set_issuer_name(certificate, X509_get_subject_name(issuer)) == 1 &&
         add_extension(certificate, issuer, NID_subject_key_identifier, "hash") &&
         add_extension(certificate, issuer, NID_authority_key_identifier, "keyid:always") &&
         X509_sign(certificate, key.get(), EVP_sha256()) > 0;
}

Result<Certificate> read_again(CertificateHandle made, std::string_view what) {
  return Certificate::of_pem(Certificate(std::move(made)).pem(), what);
}

Result<Certificate> issue(const CertificateOrder& order, const Certificate& authority, const PrivateKey& key) {
  auto made = begin_certificate(order.organisation, order.name, std::min(order.ends, authority.ends()), order.key);
  if (made == nullptr || !add_extension(made.get(), authority.get(), NID_basic_constraints, "critical,CA:FALSE") ||
      !add_extension(made.get(), authority.get(), NID_key_usage, "critical,digitalSignature") ||
      !add_extension(made.get(), authority.get(), NID_ext_key_usage, "clientAuth,serverAuth") ||
      !add_alternative_names(made.get(), order) || !finish_certificate(made.get(), authority.get(), key))
    return openssl_failed(fmt::format("make the certificate of {}", order.name));
  return read_again(std::move(made), order.name);
}

Result<Certificate> make_authority(AuthorityKind kind, const std::string& organisation, WallTime ends,
                                   const PrivateKey& key) {
  const bool identities = kind == AuthorityKind::kIdentities;
  auto made = begin_certificate(organisation, identities ? "identities" : "permissions", ends, key.get());
  auto* raw = made.get();
  const bool good =
      raw != nullptr && X509_set_issuer_name(raw, X509_get_subject_name(raw)) == 1 &&
      add_extension(raw, raw, NID_basic_constraints, identities ? "critical,CA:TRUE,pathlen:0" : "critical,CA:FALSE") &&
      add_extension(raw, raw, NID_key_usage,
                    identities ? "critical,keyCertSign,cRLSign" : "critical,digitalSignature") &&
      (identities || add_extension(raw, raw, NID_ext_key_usage, "emailProtection")) &&
      finish_certificate(raw, raw, key);
  if (!good) return openssl_failed("make an authority");
  return read_again(std::move(made), "the new authority");
}

}  // namespace rubicon::trust
