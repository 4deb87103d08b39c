#include "trust/fingerprint.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace rubicon::trust {

std::string fingerprint_of(std::string_view bytes) {
  std::array<unsigned char, 32> digest{};
  if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), nullptr, EVP_sha256(), nullptr) != 1) return {};
  std::string text;
  for (std::size_t i = 0; i < digest.size(); ++i)
    text += fmt::format("{}{:02X}", i > 0 && i % 2 == 0 ? " " : "", digest[i]);
  return text;
}

std::string fingerprint_of(EVP_PKEY* key) {
  unsigned char* bytes = nullptr;
  const int size = i2d_PUBKEY(key, &bytes);
  const std::string der(reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(std::max(size, 0)));
  OPENSSL_free(bytes);
  return der.empty() ? std::string() : fingerprint_of(der);
}

}  // namespace rubicon::trust
