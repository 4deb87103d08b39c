#pragma once

#include <string>

#include "trust/certificate.h"

namespace rubicon::trust {

// What all certificates of our authorities have in common.

using AlternativeNames = std::unique_ptr<GENERAL_NAMES, Releaser<GENERAL_NAMES_free>>;

/// All but the extensions and the signature: O and CN, a random serial number, from 2020 until `ends`. Empty: OpenSSL
/// failed.
CertificateHandle begin_certificate(const std::string& organisation, const std::string& name, WallTime ends,
                                    EVP_PKEY* key);
/// By number and text, as the configuration of OpenSSL spells it.
bool add_extension(X509* certificate, X509* issuer, int nid, const char* text);
/// Key identifiers and the signature.
bool finish_certificate(X509* certificate, X509* issuer, const PrivateKey& key);
/// The same certificate without what OpenSSL remembers of its extensions from before they were complete.
Result<Certificate> read_again(CertificateHandle made, std::string_view what);

/// The certificate in DER.
std::string der_of(const Certificate& certificate);

}  // namespace rubicon::trust
