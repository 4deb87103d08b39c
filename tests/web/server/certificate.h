#pragma once

#include <gtest/gtest.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <cstdio>
#include <ctime>
#include <memory>
#include <string>

#include "web/server/server.h"

namespace rubicon::web::server {

/// Writes a certificate for itself and its key to `<path>.pem` and `<path>.key`.
inline TlsFiles write_certificate(const std::string& path, long serial, std::time_t expires) {
  const std::unique_ptr<EVP_PKEY, void (*)(EVP_PKEY*)> key(EVP_EC_gen("P-256"), EVP_PKEY_free);
  const std::unique_ptr<X509, void (*)(X509*)> certificate(X509_new(), X509_free);
  ASN1_INTEGER_set(X509_get_serialNumber(certificate.get()), serial);
  ASN1_TIME_set(X509_getm_notBefore(certificate.get()), 0);
  ASN1_TIME_set(X509_getm_notAfter(certificate.get()), expires);
  X509_set_pubkey(certificate.get(), key.get());
  auto* name = X509_get_subject_name(certificate.get());
  X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, reinterpret_cast<const unsigned char*>("localhost"), -1, -1, 0);
  X509_set_issuer_name(certificate.get(), name);
  X509_sign(certificate.get(), key.get(), EVP_sha256());
  TlsFiles files{path + ".pem", path + ".key"};
  for (const bool secret : {false, true}) {
    FILE* file = std::fopen((secret ? files.key : files.certificate).c_str(), "w");
    EXPECT_NE(file, nullptr);
    if (secret) {
      PEM_write_PrivateKey(file, key.get(), nullptr, nullptr, 0, nullptr, nullptr);
    } else {
      PEM_write_X509(file, certificate.get());
    }
    std::fclose(file);
  }
  return files;
}

}  // namespace rubicon::web::server
