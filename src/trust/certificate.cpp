#include "trust/certificate.h"

#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/pem.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <optional>

#include "base/printable.h"
#include "trust/certificate_parts.h"
#include "trust/id_ranges.h"
#include "trust/operations.h"

namespace rubicon::trust {

namespace {

constexpr std::string_view kIdsUri = "rubicon:";
constexpr std::string_view kRolesUri = "rubicon-roles:";
constexpr int kMostAlternativeNames = 16;

using NamesHandle = std::unique_ptr<GENERAL_NAMES, Releaser<GENERAL_NAMES_free>>;

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

/// What follows the prefix in the only URI that begins with it.
struct Uris {
  std::optional<std::string> ids, roles;
};

Result<void> take_uri(std::string_view uri, Uris& uris) {
  for (auto [prefix, target] : {std::pair(kIdsUri, &uris.ids), std::pair(kRolesUri, &uris.roles)}) {
    if (!uri.starts_with(prefix)) continue;
    if (*target) return fail(ErrorCode::kInvalid, fmt::format("has two names that begin with `{}`", prefix));
    *target = std::string(uri.substr(prefix.size()));
  }
  return {};
}

Result<Uris> uris_of(const X509* certificate) {
  Uris uris;
  int critical = 0;
  const NamesHandle names(
      static_cast<GENERAL_NAMES*>(X509_get_ext_d2i(certificate, NID_subject_alt_name, &critical, nullptr)));
  ERR_clear_error();
  if (names == nullptr) return fail(ErrorCode::kInvalid, "has no alternative names of its subject, or several lists");
  const int count = sk_GENERAL_NAME_num(names.get());
  if (count > kMostAlternativeNames) return fail(ErrorCode::kInvalid, fmt::format("has {} alternative names", count));
  for (int i = 0; i < count; ++i) {
    const auto* name = sk_GENERAL_NAME_value(names.get(), i);
    if (name->type != GEN_URI) continue;
    const auto* uri = name->d.uniformResourceIdentifier;
    const std::string_view text(reinterpret_cast<const char*>(ASN1_STRING_get0_data(uri)),
                                static_cast<std::size_t>(ASN1_STRING_length(uri)));
    if (auto taken = take_uri(text, uris); !taken) return fail(taken.error());
  }
  return uris;
}

Result<tuples::Member> read_member(const Certificate& certificate) {
  tuples::Member member;
  const auto* subject = X509_get_subject_name(certificate.get());
  const auto name = only_entry(subject, NID_commonName);
  if (!name) return fail(ErrorCode::kInvalid, "has no single common name (CN)");
  if (auto checked = check_member_name(*name); !checked) return fail(checked.error());
  member.name = *name;
  auto uris = uris_of(certificate.get());
  if (!uris) return fail(uris.error());
  if (!uris->ids) return fail(ErrorCode::kInvalid, "has no ids: expected the alternative name URI:rubicon:<ranges>");
  auto ids = parse_ranges(*uris->ids);
  if (!ids) return fail(ids.error());
  member.ids = std::move(*ids);
  auto roles = parse_roles(uris->roles.value_or(""));
  if (!roles) return fail(roles.error());
  member.roles = std::move(*roles);
  member.serial = certificate.serial();
  member.expires = certificate.ends();
  return member;
}

}  // namespace

Result<Certificate> Certificate::of_pem(std::string_view pem, std::string_view where) {
  if (pem.size() > kLargestCertificate)
    return invalid_input(where, fmt::format("is no certificate: has more than {} bytes", kLargestCertificate));
  const auto bio = reading(pem);
  CertificateHandle read(PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr));
  if (read == nullptr) return invalid_input(where, "is no certificate in PEM");
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

Result<tuples::Member> Certificate::member(std::string_view where) const {
  auto read = read_member(*this);
  if (!read) return invalid_input(where, read.error().text);
  return read;
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

}  // namespace rubicon::trust
