#pragma once

#include <openssl/x509.h>

#include <memory>
#include <string>
#include <vector>

namespace rubicon::trust::guard {

struct KeyEnd {
  void operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
};
struct CertificateEnd {
  void operator()(X509* certificate) const { X509_free(certificate); }
};

/// A certificate and its key.
struct Signer {
  std::unique_ptr<EVP_PKEY, KeyEnd> key;
  std::unique_ptr<X509, CertificateEnd> certificate;

  std::string key_pem() const;
  std::string certificate_pem() const;
};

struct Subject {
  std::string name;                                ///< CN
  std::string organization = "Rubicon test";       ///< O
  std::vector<std::string> uris{};                 ///< alternative names: `rubicon:01a00000-01afffff`
  std::string purposes = "clientAuth,serverAuth";  ///< extended key usage; empty = for everything
  long serial = 1;
  long days = 1;
};

enum class Signs { Certificates, Documents, Both };
Signer make_authority(const std::string& name, Signs what);
Signer make_member(const Signer& authority, const Subject& subject);
/// S/MIME, as `openssl smime -sign -text`.
std::string signed_text(const Signer& signer, const std::string& xml);

std::string governance_xml();
/// May write `writes` and read `reads` (partitions) of the topics of Rubicon.
std::string permissions_xml(const Subject& subject, const std::string& writes, const std::string& reads);

/// The six files that a participant needs, in a folder.
struct Documents {
  std::string identity_ca, certificate, key, permissions_ca, governance, permissions;

  void write_to(const std::string& folder) const;
};

}  // namespace rubicon::trust::guard
