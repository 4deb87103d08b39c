#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "rubicon/result.hpp"
#include "trust/openssl_handles.h"
#include "trust/private_key.h"

namespace rubicon::trust {

/// A request for a certificate (PKCS 10): a name and a public key, signed with the private one. Ids and roles are for
/// the authority to decide.
class CertificateRequest {
 public:
  /// A request in PEM with a good signature, the name of a member as its only common name, and a key on P-256.
  static Result<CertificateRequest> of_pem(std::string_view pem, std::string_view where);
  /// A new one, in PEM.
  static Result<std::string> make(const std::string& name, const PrivateKey& key);

  const std::string& name() const { return name_; }
  EVP_PKEY* key() const { return X509_REQ_get0_pubkey(request_.get()); }

 private:
  CertificateRequest(RequestHandle request, std::string name) : request_(std::move(request)), name_(std::move(name)) {}

  RequestHandle request_;
  std::string name_;
};

}  // namespace rubicon::trust
