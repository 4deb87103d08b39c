#include <fmt/format.h>
#include <openssl/pem.h>

#include <algorithm>

#include "trust/site/site_certificates.h"

namespace rubicon::trust::site {

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

}  // namespace rubicon::trust::site
