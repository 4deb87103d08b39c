#include "trust/certificate.h"

#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/rand.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <optional>
#include <tuple>

#include "base/text.h"

namespace rubicon::trust {

namespace {

constexpr WallTime kFirstDay = std::chrono::sys_days(std::chrono::year(2020) / 1 / 1);

std::time_t seconds_of(WallTime time) {
  return std::chrono::duration_cast<std::chrono::seconds>(time.time_since_epoch()).count();
}

WallTime wall_time_of(const ASN1_TIME* time) {
  std::tm parts{};
  if (time == nullptr || ASN1_TIME_to_tm(time, &parts) != 1) return {};
  return WallTime(std::chrono::seconds(::timegm(&parts)));
}

/// The only entry of this type in a name; nullopt: none, several, or not a text.
std::optional<std::string> only_entry(const X509_NAME* name, int nid) {
  const int at = X509_NAME_get_index_by_NID(name, nid, -1);
  if (at < 0 || X509_NAME_get_index_by_NID(name, nid, at) >= 0) return {};
  unsigned char* text = nullptr;
  const int size = ASN1_STRING_to_UTF8(&text, X509_NAME_ENTRY_get_data(X509_NAME_get_entry(name, at)));
  if (size < 0) {
    ERR_clear_error();
    return {};
  }
  const std::string copy(reinterpret_cast<const char*>(text), static_cast<std::size_t>(size));
  OPENSSL_free(text);
  return copy;
}

constexpr long kVersion3 = 2;

bool set_subject(X509_NAME* name, const std::string& organisation, const std::string& common) {
  const auto add = [name](const char* field, const std::string& text) {
    return X509_NAME_add_entry_by_txt(name, field, MBSTRING_UTF8, reinterpret_cast<const unsigned char*>(text.data()),
                                      static_cast<int>(text.size()), -1, 0) == 1;
  };
  return add("O", organisation) && add("CN", common);
}

/// 127 random bits with the first one set: always 32 hexadecimal digits.
bool set_serial(X509* certificate) {
  std::array<unsigned char, 16> random{};
  if (RAND_bytes(random.data(), static_cast<int>(random.size())) != 1) return false;
  random[0] = static_cast<unsigned char>((random[0] & 0x7fU) | 0x40U);
  const NumberHandle number(BN_bin2bn(random.data(), static_cast<int>(random.size()), nullptr));
  return number != nullptr && BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(certificate)) != nullptr;
}

bool set_dates(X509* certificate, WallTime ends) {
  return ASN1_TIME_set(X509_getm_notBefore(certificate), seconds_of(kFirstDay)) != nullptr &&
         ASN1_TIME_set(X509_getm_notAfter(certificate), seconds_of(ends)) != nullptr;
}

}  // namespace

Result<Certificate> Certificate::of_pem(std::string_view pem, std::string_view where) {
  if (pem.size() > kMaxCertificate)
    return invalid_input(where, fmt::format("is not a certificate: has more than {} bytes", kMaxCertificate));
  const auto bio = reading(pem);
  CertificateHandle read(PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr));
  if (read == nullptr) return invalid_input(where, "is not a certificate in PEM");
  Certificate certificate(std::move(read));
  if (certificate.pem() != pem)
    return invalid_input(where, "has more, or is written in another way, than one certificate in PEM");
  if (certificate.serial().size() > 64) return invalid_input(where, "has a serial number of more than 32 bytes");
  return certificate;
}

std::string Certificate::pem() const {
  const auto bio = writing();
  if (bio == nullptr || PEM_write_bio_X509(bio.get(), get()) != 1) return {};
  return written_text(bio.get());
}

std::string Certificate::subject() const {
  const auto bio = writing();
  if (bio == nullptr || X509_NAME_print_ex(bio.get(), X509_get_subject_name(get()), 0, XN_FLAG_RFC2253) < 0) return {};
  return base::one_line(written_text(bio.get()));
}

std::string Certificate::organisation() const {
  return base::one_line(only_entry(X509_get_subject_name(get()), NID_organizationName).value_or(""));
}

std::string Certificate::common_name() const {
  return only_entry(X509_get_subject_name(get()), NID_commonName).value_or("");
}

WallTime Certificate::begins() const {
  return wall_time_of(X509_get0_notBefore(get()));
}

WallTime Certificate::ends() const {
  return wall_time_of(X509_get0_notAfter(get()));
}

std::string Certificate::serial() const {
  const NumberHandle number(ASN1_INTEGER_to_BN(X509_get0_serialNumber(get()), nullptr));
  char* digits = number == nullptr ? nullptr : BN_bn2hex(number.get());
  if (digits == nullptr) return {};
  const std::string text = digits;
  OPENSSL_free(digits);
  return text;
}

bool Certificate::has_key(const EVP_PKEY* key) const {
  const bool same = key != nullptr && EVP_PKEY_eq(X509_get0_pubkey(get()), key) == 1;
  ERR_clear_error();
  return same;
}

std::string der_of(const Certificate& certificate) {
  unsigned char* bytes = nullptr;
  const int size = i2d_X509(certificate.get(), &bytes);
  std::string der(reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(std::max(size, 0)));
  OPENSSL_free(bytes);
  return der;
}

bool operator==(const Certificate& left, const Certificate& right) {
  return X509_cmp(left.get(), right.get()) == 0;
}

std::string date_text(WallTime time) {
  const auto seconds = seconds_of(time);
  std::tm parts{};
  if (::gmtime_r(&seconds, &parts) == nullptr) return fmt::format("{} s after 1970", seconds);
  return fmt::format("{:04}-{:02}-{:02} {:02}:{:02} UTC", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday,
                     parts.tm_hour, parts.tm_min);
}

Result<void> check_clock(WallTime now, std::string_view where) {
  if (now >= kFirstDay) return {};
  return fail(ErrorCode::kExpired,
              fmt::format("{}: the clock of this host says {}: expected a time after 2020; set the clock", where,
                          date_text(now)));
}

Result<void> check_dates(const Certificate& certificate, WallTime now, std::string_view where) {
  if (auto clock = check_clock(now, where); !clock) return clock;
  if (now < certificate.begins())
    return fail(ErrorCode::kExpired,
                fmt::format("{}: {} is not valid before {}, and the clock says {}", where, certificate.subject(),
                            date_text(certificate.begins()), date_text(now)));
  if (now < certificate.ends()) return {};
  return fail(ErrorCode::kExpired,
              fmt::format("{}: {} ended on {}, and the clock says {}: renew it, or set the clock", where,
                          certificate.subject(), date_text(certificate.ends()), date_text(now)));
}

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
  if (document.size() > kMaxSigned) return invalid_input(where, fmt::format("has more than {} bytes", kMaxSigned));
  const auto parts = parts_of(document);
  if (parts.signature == nullptr || parts.content == nullptr || !has_one_signature(parts.signature.get()))
    return invalid_input(where, "is not a document with one signature (S/MIME)");
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
