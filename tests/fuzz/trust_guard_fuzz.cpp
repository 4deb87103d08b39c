#include <openssl/evp.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "fuzz_target.h"
#include "trust/guard/certificate.h"

namespace rubicon::fuzz::trust_guard_fuzz {

namespace {

using namespace rubicon::trust::guard;

void check(const std::string& pem) {
  const auto read = read_certificate(pem);
  const auto claimed = claimed_name(pem);
  if (read.certificate.has_value() != read.reason.empty() || claimed.size() > 64) __builtin_trap();
  if (!read.certificate) return;
  const auto& certificate = *read.certificate;
  if (certificate.name != claimed || certificate.ids.size() > 256 || certificate.roles.size() > 256) __builtin_trap();
  if (certificate.serial.empty() || plain_serial(certificate.serial) != certificate.serial) __builtin_trap();
}

std::string pem_of(const std::uint8_t* der, std::size_t size) {
  std::string text(4 * (size / 3 + 1) + 1, '\0');
  const int length = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), der, static_cast<int>(size));
  text.resize(static_cast<std::size_t>(length));
  for (std::size_t at = 64; at < text.size(); at += 65) text.insert(at, "\n");
  return "-----BEGIN CERTIFICATE-----\n" + text + "\n-----END CERTIFICATE-----\n";
}

}  // namespace

/// The certificate that a stranger shows: PEM, or what is inside (DER).
FUZZ_TARGET(trust_guard) {
  if (size > 70'000) return 0;
  check(std::string(reinterpret_cast<const char*>(data), size));
  check(pem_of(data, size));
  return 0;
}

}  // namespace rubicon::fuzz::trust_guard_fuzz
