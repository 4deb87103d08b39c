#include "trust/certificate_request.h"

#include <fmt/format.h>
#include <openssl/pem.h>

#include <array>

#include "trust/operations.h"

namespace rubicon::trust {

namespace {

constexpr std::size_t kLargestRequest = 16384;

}  // namespace

Result<CertificateRequest> CertificateRequest::of_pem(std::string_view pem, std::string_view where) {
  if (pem.size() > kLargestRequest) return invalid_input(where, fmt::format("has more than {} bytes", kLargestRequest));
  const auto bio = reading(pem);
  RequestHandle request(PEM_read_bio_X509_REQ(bio.get(), nullptr, nullptr, nullptr));
  if (request == nullptr) return invalid_input(where, "is no request for a certificate in PEM");
  auto* key = X509_REQ_get0_pubkey(request.get());
  if (!is_p256(key)) return invalid_input(where, "has no key on the curve P-256");
  if (X509_REQ_verify(request.get(), key) != 1) return invalid_input(where, "is not signed with its own key");
  std::array<char, 80> name{};
  const int size = X509_NAME_get_text_by_NID(X509_REQ_get_subject_name(request.get()), NID_commonName, name.data(),
                                             static_cast<int>(name.size()));
  const std::string text(name.data(), static_cast<std::size_t>(size < 0 ? 0 : size));
  if (auto checked = check_member_name(text); !checked) return invalid_input(where, checked.error().text);
  return CertificateRequest(std::move(request), text);
}

Result<std::string> CertificateRequest::make(const std::string& name, const PrivateKey& key) {
  const RequestHandle request(X509_REQ_new());
  const auto bio = writing();
  const auto* text = reinterpret_cast<const unsigned char*>(name.data());
  if (request == nullptr || bio == nullptr ||
      X509_NAME_add_entry_by_txt(X509_REQ_get_subject_name(request.get()), "CN", MBSTRING_UTF8, text,
                                 static_cast<int>(name.size()), -1, 0) != 1 ||
      X509_REQ_set_pubkey(request.get(), key.get()) != 1 ||
      X509_REQ_sign(request.get(), key.get(), EVP_sha256()) <= 0 ||
      PEM_write_bio_X509_REQ(bio.get(), request.get()) != 1)
    return openssl_failed(fmt::format("request a certificate for {}", name));
  return written_text(bio.get());
}

}  // namespace rubicon::trust
