#include "trust/private_key.h"

#include <fmt/format.h>
#include <openssl/ec.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/pkcs12.h>
#include <openssl/rand.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cstdint>

#include "trust/secret_text.h"

namespace rubicon::trust {

namespace {

/// Empty if OpenSSL has none.
std::string first_reason() {
  const auto code = ERR_get_error();
  const auto* reason = code == 0 ? nullptr : ERR_reason_error_string(code);
  ERR_clear_error();
  return reason == nullptr ? "" : reason;
}

}  // namespace

BioHandle reading(std::string_view text) {
  const auto size = text.size() > INT_MAX ? INT_MAX : static_cast<int>(text.size());
  return BioHandle(BIO_new_mem_buf(text.empty() ? "" : text.data(), size));
}

BioHandle writing() {
  return BioHandle(BIO_new(BIO_s_mem()));
}

std::string written_text(BIO* bio) {
  char* start = nullptr;
  const auto size = BIO_get_mem_data(bio, &start);
  return size <= 0 ? std::string() : std::string(start, static_cast<std::size_t>(size));
}

tl::unexpected<Error> openssl_failed(std::string_view operation) {
  const auto reason = first_reason();
  return fail(ErrorCode::kIo, fmt::format("OpenSSL cannot {}: {}", operation, reason.empty() ? "no reason" : reason));
}

tl::unexpected<Error> invalid_input(std::string_view where, std::string_view what) {
  const auto reason = first_reason();
  return fail(ErrorCode::kInvalid,
              reason.empty() ? fmt::format("{}: {}", where, what) : fmt::format("{}: {} ({})", where, what, reason));
}

namespace {

using KeyInfoHandle = std::unique_ptr<PKCS8_PRIV_KEY_INFO, Releaser<PKCS8_PRIV_KEY_INFO_free>>;
using EnvelopeHandle = std::unique_ptr<X509_SIG, Releaser<X509_SIG_free>>;
using SchemeHandle = std::unique_ptr<PBE2PARAM, Releaser<PBE2PARAM_free>>;
using DerivationHandle = std::unique_ptr<PBKDF2PARAM, Releaser<PBKDF2PARAM_free>>;

constexpr std::size_t kMaxPem = 4096;
/// 32 of them: 5 bits each. Without 0, 1, l, o.
constexpr std::string_view kAlphabet = "abcdefghijkmnpqrstuvwxyz23456789";
constexpr std::size_t kGroups = 6, kGroupSize = 4;

/// Fails instead of asking the terminal for a pass phrase.
int no_phrase(char*, int, int, void*) {
  return -1;
}

bool is_whole(EVP_PKEY* key) {
  const KeyContextHandle context(EVP_PKEY_CTX_new(key, nullptr));
  return context != nullptr && EVP_PKEY_check(context.get()) == 1;
}

int nid_of(const X509_ALGOR* algorithm) {
  const ASN1_OBJECT* object = nullptr;
  X509_ALGOR_get0(&object, nullptr, nullptr, algorithm);
  return OBJ_obj2nid(object);
}

template <class T>
T* parameters_of(const X509_ALGOR* algorithm, const ASN1_ITEM* item) {
  return static_cast<T*>(ASN1_TYPE_unpack_sequence(item, algorithm->parameter));
}

/// Before the phrase is tried: the rounds come from the file.
bool has_our_protection(const X509_SIG* envelope) {
  const X509_ALGOR* algorithm = nullptr;
  X509_SIG_get0(envelope, &algorithm, nullptr);
  if (nid_of(algorithm) != NID_pbes2) return false;
  const SchemeHandle scheme(parameters_of<PBE2PARAM>(algorithm, ASN1_ITEM_rptr(PBE2PARAM)));
  if (scheme == nullptr || nid_of(scheme->encryption) != NID_aes_256_cbc || nid_of(scheme->keyfunc) != NID_id_pbkdf2)
    return false;
  const DerivationHandle derivation(parameters_of<PBKDF2PARAM>(scheme->keyfunc, ASN1_ITEM_rptr(PBKDF2PARAM)));
  if (derivation == nullptr || derivation->prf == nullptr || nid_of(derivation->prf) != NID_hmacWithSHA256)
    return false;
  std::int64_t rounds = 0;
  return ASN1_INTEGER_get_int64(&rounds, derivation->iter) == 1 && rounds >= PrivateKey::kRounds &&
         rounds <= PrivateKey::kMaxRoundCount;
}

}  // namespace

bool is_p256(const EVP_PKEY* key) {
  std::array<char, 32> name{};
  return key != nullptr && EVP_PKEY_is_a(key, "EC") == 1 &&
         EVP_PKEY_get_group_name(key, name.data(), name.size(), nullptr) == 1 &&
         std::string_view(name.data()) == SN_X9_62_prime256v1;
}

Result<PrivateKey> PrivateKey::make() {
  KeyHandle key(EVP_EC_gen(SN_X9_62_prime256v1));
  if (key == nullptr) return openssl_failed("make a key");
  return PrivateKey(std::move(key));
}

Result<PrivateKey> PrivateKey::of_pem(std::string_view pem, std::string_view where) {
  static constexpr std::string_view kBegin = "-----BEGIN PRIVATE KEY-----";
  if (pem.size() > kMaxPem || !pem.starts_with(kBegin))
    return invalid_input(where, fmt::format("is not a private key: expected PEM that begins with {}", kBegin));
  const auto bio = reading(pem);
  KeyHandle key(PEM_read_bio_PrivateKey(bio.get(), nullptr, no_phrase, nullptr));
  if (key == nullptr) return invalid_input(where, "is not a private key");
  if (!is_p256(key.get()) || !is_whole(key.get()))
    return invalid_input(where, "is not a good private key: expected one on the curve P-256 whose two parts fit");
  return PrivateKey(std::move(key));
}

Result<PrivateKey> PrivateKey::decrypted(std::string_view pem, std::string_view phrase, std::string_view where) {
  const auto bio = reading(pem.substr(0, kMaxPem));
  const EnvelopeHandle envelope(PEM_read_bio_PKCS8(bio.get(), nullptr, no_phrase, nullptr));
  if (envelope == nullptr) return invalid_input(where, "has no encrypted private key");
  if (!has_our_protection(envelope.get()))
    return invalid_input(where, fmt::format("the key is not protected as expected: by PBKDF2 with {} to {} rounds of "
                                            "HMAC-SHA-256, and AES-256-CBC",
                                            kRounds, kMaxRoundCount));
  const auto plain = plain_phrase(phrase);
  const auto text = plain.view();
  const KeyInfoHandle info(PKCS8_decrypt(envelope.get(), text.data(), static_cast<int>(text.size())));
  KeyHandle key(info == nullptr ? nullptr : EVP_PKCS82PKEY(info.get()));
  ERR_clear_error();
  if (key == nullptr || !is_p256(key.get()) || !is_whole(key.get()))
    return fail(ErrorCode::kRefused, fmt::format("{}: the pass phrase does not open it: expected the {} groups of {} "
                                                 "letters and digits that were shown when it was made",
                                                 where, kGroups, kGroupSize));
  return PrivateKey(std::move(key));
}

Result<SecretText> PrivateKey::pem() const {
  const auto bio = writing();
  if (bio == nullptr || PEM_write_bio_PKCS8PrivateKey(bio.get(), get(), nullptr, nullptr, 0, nullptr, nullptr) != 1)
    return openssl_failed("write a key");
  char* start = nullptr;
  const auto size = BIO_get_mem_data(bio.get(), &start);
  SecretText text(std::string(start, static_cast<std::size_t>(size)));
  OPENSSL_cleanse(start, static_cast<std::size_t>(size));
  return text;
}

Result<std::string> PrivateKey::encrypted(std::string_view phrase) const {
  KeyInfoHandle info(EVP_PKEY2PKCS8(get()));
  std::array<unsigned char, 16> salt{};
  if (info == nullptr || RAND_bytes(salt.data(), static_cast<int>(salt.size())) != 1)
    return openssl_failed("encrypt a key");
  auto* scheme = PKCS5_pbe2_set_iv(EVP_aes_256_cbc(), kRounds, salt.data(), static_cast<int>(salt.size()), nullptr,
                                   NID_hmacWithSHA256);
  const auto plain = plain_phrase(phrase);
  const auto text = plain.view();
  // Takes the scheme.
  const EnvelopeHandle envelope(
      scheme == nullptr ? nullptr : PKCS8_set0_pbe(text.data(), static_cast<int>(text.size()), info.get(), scheme));
  const auto bio = writing();
  if (envelope == nullptr || bio == nullptr || PEM_write_bio_PKCS8(bio.get(), envelope.get()) != 1)
    return openssl_failed("encrypt a key");
  return written_text(bio.get());
}

Result<SecretText> new_phrase() {
  std::array<unsigned char, kGroups * kGroupSize> random{};
  if (RAND_bytes(random.data(), static_cast<int>(random.size())) != 1) return openssl_failed("make a pass phrase");
  std::string text;
  text.reserve(random.size() + kGroups);
  for (std::size_t i = 0; i < random.size(); ++i) {
    if (i > 0 && i % kGroupSize == 0) text += '-';
    text += kAlphabet[random[i] % kAlphabet.size()];
  }
  OPENSSL_cleanse(random.data(), random.size());
  return SecretText(std::move(text));
}

SecretText plain_phrase(std::string_view typed) {
  std::string plain;
  plain.reserve(typed.size());
  for (const char c : typed) {
    if (c == '-' || c == ' ' || c == '\t' || c == '\r' || c == '\n') continue;
    plain += 'A' <= c && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return SecretText(std::move(plain));
}

void keep_memory_private() {
  constexpr rlimit kNone{0, 0};
  ::setrlimit(RLIMIT_CORE, &kNone);
  ::prctl(PR_SET_DUMPABLE, 0);
}

}  // namespace rubicon::trust
