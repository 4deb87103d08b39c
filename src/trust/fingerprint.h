#pragma once

#include <string>

#include "trust/openssl_handles.h"

namespace rubicon::trust {

/// SHA-256 as people compare it: 16 groups of 4 upper-case digits, separated by blanks. Empty: OpenSSL failed.
std::string fingerprint_of(std::string_view bytes);
/// That of a public key (SubjectPublicKeyInfo in DER).
std::string fingerprint_of(EVP_PKEY* key);

}  // namespace rubicon::trust
