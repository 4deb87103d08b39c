#include "trust/guard/certificate.h"

#include <openssl/asn1.h>
#include <openssl/bio.h>
#include <openssl/bn.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/sha.h>
#include <openssl/x509v3.h>

#include <algorithm>
#include <ctime>
#include <memory>

namespace rubicon::trust::guard {

namespace {

constexpr std::size_t kLongestPem = 65536;
constexpr std::size_t kLongestName = 64;
constexpr std::size_t kLongestUri = 256;
constexpr std::size_t kLongestSerial = 64;
constexpr std::string_view kIdsUri = "rubicon:";
constexpr std::string_view kRolesUri = "rubicon-roles:";

template <auto free>
struct Freed {
  template <class T>
  void operator()(T* it) const {
    free(it);
  }
};
using X509Ptr = std::unique_ptr<X509, Freed<X509_free>>;
using BioPtr = std::unique_ptr<BIO, Freed<BIO_free>>;
using NamesPtr = std::unique_ptr<GENERAL_NAMES, Freed<GENERAL_NAMES_free>>;

/// OpenSSL's own asks at the terminal when a PEM is encrypted.
int no_password(char*, int, int, void*) {
  return 0;
}

X509Ptr parse(std::string_view pem) {
  if (pem.empty() || pem.size() > kLongestPem) return nullptr;
  const BioPtr bio(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
  X509Ptr certificate(bio ? PEM_read_bio_X509(bio.get(), nullptr, no_password, nullptr) : nullptr);
  ERR_clear_error();  // others in this process would take it for theirs
  return certificate;
}

bool plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}
bool of_name(char c) {
  return plain(c) || c == '.' || c == '_' || c == '-';
}

std::string_view text_of(const ASN1_STRING* text) {
  const auto length = ASN1_STRING_length(text);
  if (length <= 0) return {};
  return {reinterpret_cast<const char*>(ASN1_STRING_get0_data(text)), static_cast<std::size_t>(length)};
}

/// The only CN; nullopt: there is none, or more than one.
std::optional<std::string_view> common_name(const X509* certificate) {
  const auto* subject = X509_get_subject_name(certificate);
  const int first = X509_NAME_get_index_by_NID(subject, NID_commonName, -1);
  if (first < 0 || X509_NAME_get_index_by_NID(subject, NID_commonName, first) >= 0) return std::nullopt;
  return text_of(X509_NAME_ENTRY_get_data(X509_NAME_get_entry(subject, first)));
}

/// Calls `each` with the parts between commas; false as soon as it does.
template <class Each>
bool all_parts(std::string_view list, Each each) {
  while (true) {
    const auto comma = list.find(',');
    if (!each(list.substr(0, comma))) return false;
    if (comma == list.npos) return true;
    list.remove_prefix(comma + 1);
  }
}

bool is_range(std::string_view part) {
  constexpr std::size_t kDigits = 8;
  const auto hexadecimal = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  if (part.size() != 2 * kDigits + 1 || part[kDigits] != '-') return false;
  const auto first = part.substr(0, kDigits);
  const auto last = part.substr(kDigits + 1);
  return std::ranges::all_of(first, hexadecimal) && std::ranges::all_of(last, hexadecimal) && first <= last;
}

bool is_role(std::string_view part) {
  return !part.empty() && std::ranges::all_of(part, of_name);
}

/// Takes one URI of the subject's alternative names; false with the reason if it is ours and wrong.
bool take_uri(std::string_view uri, Certificate& into, std::string& reason) {
  const auto take = [&](std::string_view scheme, std::string& field, auto part) {
    if (!uri.starts_with(scheme)) return true;
    const auto list = uri.substr(scheme.size());
    if (!field.empty() || uri.size() > kLongestUri || !all_parts(list, part)) {
      reason = "its URI " + std::string(scheme) + " is malformed";
      return false;
    }
    field = list;
    return true;
  };
  return take(kIdsUri, into.ids, is_range) && take(kRolesUri, into.roles, is_role);
}

bool take_alternative_names(const X509* certificate, Certificate& into, std::string& reason) {
  int found = 0;
  const NamesPtr names(
      static_cast<GENERAL_NAMES*>(X509_get_ext_d2i(certificate, NID_subject_alt_name, &found, nullptr)));
  ERR_clear_error();
  if (!names) {
    if (found == -1) return true;  // there are none
    reason = "its alternative names cannot be read";
    return false;
  }
  for (int i = 0; i < sk_GENERAL_NAME_num(names.get()); ++i) {
    const auto* name = sk_GENERAL_NAME_value(names.get(), i);
    if (name->type != GEN_URI) continue;
    if (!take_uri(text_of(name->d.uniformResourceIdentifier), into, reason)) return false;
  }
  return true;
}

std::string serial_of(const X509* certificate) {
  const std::unique_ptr<BIGNUM, Freed<BN_free>> number(
      ASN1_INTEGER_to_BN(X509_get0_serialNumber(certificate), nullptr));
  if (!number || BN_is_negative(number.get()) || BN_num_bytes(number.get()) > static_cast<int>(kLongestSerial / 2))
    return {};
  char* digits = BN_bn2hex(number.get());
  if (digits == nullptr) return {};
  auto text = plain_serial(digits);
  OPENSSL_free(digits);
  return text;
}

bool take_end(const X509* certificate, Certificate& into) {
  std::tm time{};
  if (ASN1_TIME_to_tm(X509_get0_notAfter(certificate), &time) != 1) return false;
  into.expires = ::timegm(&time);
  return true;
}

/// A one bit and the first 47 bits of the hash of the subject: DDS Security 1.1, 9.3.3, table 52.
bool take_prefix(const X509* certificate, Certificate& into) {
  unsigned char* der = nullptr;
  const int size = i2d_X509_NAME(X509_get_subject_name(certificate), &der);
  if (size <= 0) return false;
  std::array<unsigned char, SHA256_DIGEST_LENGTH> hash{};
  SHA256(der, static_cast<std::size_t>(size), hash.data());
  OPENSSL_free(der);
  unsigned carry = 0x80;
  for (std::size_t i = 0; i < into.prefix.size(); ++i) {
    into.prefix[i] = static_cast<std::uint8_t>(carry | (static_cast<unsigned>(hash[i]) >> 1U));
    carry = (static_cast<unsigned>(hash[i]) << 7U) & 0xffU;
  }
  return true;
}

}  // namespace

Reading read_certificate(std::string_view pem) {
  const auto x509 = parse(pem);
  if (!x509) return {{}, "its certificate cannot be read"};
  Reading read{Certificate{}, {}};
  const auto refuse = [](std::string reason) { return Reading{{}, std::move(reason)}; };
  const auto name = common_name(x509.get());
  if (!name || name->empty() || name->size() > kLongestName || !std::ranges::all_of(*name, of_name))
    return refuse("its certificate has not one common name of at most 64 letters, digits, '.', '_' and '-'");
  read.certificate->name = *name;
  if (!take_alternative_names(x509.get(), *read.certificate, read.reason)) return refuse(read.reason);
  read.certificate->serial = serial_of(x509.get());
  if (read.certificate->serial.empty()) return refuse("the serial number of its certificate cannot be used");
  if (!take_end(x509.get(), *read.certificate)) return refuse("the end of its certificate cannot be read");
  if (!take_prefix(x509.get(), *read.certificate)) return refuse("the subject of its certificate cannot be read");
  return read;
}

std::string claimed_name(std::string_view pem) {
  const auto x509 = parse(pem);
  const auto name = x509 ? common_name(x509.get()) : std::nullopt;
  if (!name) return {};
  std::string shown(name->substr(0, kLongestName));
  std::ranges::replace_if(
      shown, [](char c) { return !of_name(c); }, '?');
  return shown;
}

std::string plain_serial(std::string_view hexadecimal) {
  if (hexadecimal.size() > kLongestSerial) return {};
  std::string serial;
  for (char c : hexadecimal) {
    if (c >= 'a' && c <= 'f') c = static_cast<char>(c - 'a' + 'A');
    if (!(c >= '0' && c <= '9') && !(c >= 'A' && c <= 'F')) return {};
    if (c != '0' || !serial.empty()) serial += c;
  }
  if (serial.empty() && !hexadecimal.empty()) return "00";
  if (serial.size() % 2 != 0) serial.insert(0, "0");
  return serial;
}

}  // namespace rubicon::trust::guard
