#include "networks/knx/secure/crypto.h"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/rand.h>

#include <algorithm>
#include <utility>

#include "base/assert.h"

namespace rubicon::networks::knx::secure {

namespace {

constexpr int kPasswordRounds = 65536;

template <auto Release>
struct Freer {
  template <class T>
  void operator()(T* object) const {
    Release(object);
  }
};
using Pkey = std::unique_ptr<EVP_PKEY, Freer<EVP_PKEY_free>>;
using PkeyContext = std::unique_ptr<EVP_PKEY_CTX, Freer<EVP_PKEY_CTX_free>>;
using CipherContext = std::unique_ptr<EVP_CIPHER_CTX, Freer<EVP_CIPHER_CTX_free>>;

/// The reason that OpenSSL gives; its queue of errors is empty afterwards.
tl::unexpected<Error> openssl_failed(std::string_view operation) {
  const auto code = ERR_get_error();
  const auto* reason = code == 0 ? nullptr : ERR_reason_error_string(code);
  ERR_clear_error();
  return fail(ErrorCode::kIo, fmt::format("OpenSSL: {}: {}", operation, reason == nullptr ? "no reason" : reason));
}

int size_of(ByteView bytes) {
  return static_cast<int>(bytes.size());
}

/// AES-128-CBC of whole blocks. `out` is as long as `in`.
Result<void> cbc(bool encrypts, const Key& key, const Block& start, ByteView in, std::uint8_t* out) {
  if (in.size() % Key::kSize != 0)
    return fail(ErrorCode::kInvalid, fmt::format("{} encrypted bytes, not a multiple of 16", in.size()));
  if (in.empty()) return {};
  const CipherContext context(EVP_CIPHER_CTX_new());
  int written = 0;
  if (context == nullptr ||
      EVP_CipherInit_ex2(context.get(), EVP_aes_128_cbc(), key.view().data(), start.data(), encrypts ? 1 : 0,
                         nullptr) != 1 ||
      EVP_CIPHER_CTX_set_padding(context.get(), 0) != 1 ||
      EVP_CipherUpdate(context.get(), out, &written, in.data(), size_of(in)) != 1)
    return openssl_failed("AES-128-CBC");
  return {};
}

}  // namespace

Random system_random() {
  return [](std::span<std::uint8_t> bytes) -> Result<void> {
    if (RAND_bytes(bytes.data(), size_of(bytes)) != 1) return openssl_failed("random bytes");
    return {};
  };
}

Result<Secret> secret_of_password(ByteView password, std::string_view salt, std::size_t size) {
  Secret secret(size);
  if (PKCS5_PBKDF2_HMAC(base::as_text(password).data(), size_of(password), base::as_bytes(salt).data(),
                        static_cast<int>(salt.size()), kPasswordRounds, EVP_sha256(), size_of(secret.view()),
                        secret.span().data()) != 1)
    return openssl_failed("PBKDF2");
  return secret;
}

Result<Key> key_of_password(ByteView password, std::string_view salt) {
  const auto secret = secret_of_password(password, salt, Key::kSize);
  if (!secret) return fail(secret.error());
  return Key(secret->view());
}

Secret base64_of(ByteView bytes) {
  Secret padded((bytes.size() + 2) / 3 * 4 + 1);  // with the zero that OpenSSL writes
  const auto size = EVP_EncodeBlock(padded.span().data(), bytes.data(), size_of(bytes));
  return Secret(padded.view().first(static_cast<std::size_t>(size)));
}

Result<Digest> sha256(ByteView bytes) {
  Digest digest{};
  if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), nullptr, EVP_sha256(), nullptr) != 1)
    return openssl_failed("SHA-256");
  return digest;
}

bool equal(ByteView left, ByteView right) {
  return left.size() == right.size() && (left.empty() || CRYPTO_memcmp(left.data(), right.data(), left.size()) == 0);
}

// X25519.

Result<KeyPair> KeyPair::make(const Random& random) {
  Secret private_key(PublicKey{}.size());
  if (auto filled = random(private_key.span()); !filled) return fail(filled.error());
  return of(std::move(private_key));
}

Result<KeyPair> KeyPair::of(Secret private_key) {
  const auto bytes = private_key.view();
  const Pkey pair(EVP_PKEY_new_raw_private_key(EVP_PKEY_X25519, nullptr, bytes.data(), bytes.size()));
  PublicKey public_key{};
  auto size = public_key.size();
  if (pair == nullptr || EVP_PKEY_get_raw_public_key(pair.get(), public_key.data(), &size) != 1)
    return openssl_failed("X25519");
  return KeyPair(std::move(private_key), public_key);
}

Result<Secret> KeyPair::shared_with(const PublicKey& peer) const {
  const auto bytes = private_.view();
  const Pkey own(EVP_PKEY_new_raw_private_key(EVP_PKEY_X25519, nullptr, bytes.data(), bytes.size()));
  const Pkey other(EVP_PKEY_new_raw_public_key(EVP_PKEY_X25519, nullptr, peer.data(), peer.size()));
  if (own == nullptr || other == nullptr) return openssl_failed("X25519");
  const PkeyContext context(EVP_PKEY_CTX_new(own.get(), nullptr));
  Secret shared(peer.size());
  auto size = shared.size();
  if (context == nullptr || EVP_PKEY_derive_init(context.get()) != 1 ||
      EVP_PKEY_derive_set_peer(context.get(), other.get()) != 1)
    return openssl_failed("X25519");
  // Fails for the few keys that give zeros whatever our own key is.
  if (EVP_PKEY_derive(context.get(), shared.span().data(), &size) != 1) {
    ERR_clear_error();
    return fail(ErrorCode::kInvalid, "the public key of the peer is not usable");
  }
  return shared;
}

Result<Secret> decrypt_cbc(const Key& key, const Block& start, ByteView encrypted) {
  Secret content(encrypted.size());
  if (auto done = cbc(false, key, start, encrypted, content.span().data()); !done) return fail(done.error());
  return content;
}

Result<Bytes> encrypt_cbc(const Key& key, const Block& start, ByteView content) {
  Bytes encrypted(content.size());
  if (auto done = cbc(true, key, start, content, encrypted.data()); !done) return fail(done.error());
  return encrypted;
}

// CCM.

struct Ccm::Contexts {
  CipherContext cbc{EVP_CIPHER_CTX_new()}, ctr{EVP_CIPHER_CTX_new()};
};

namespace {

constexpr std::uint8_t kNoKey[Key::kSize] = {};

/// Encrypts in place, then replaces the key in the context by zeros. So memory that a core dump includes never holds a
/// key for longer than a call.
bool encrypt_once(EVP_CIPHER_CTX* context, const Key& key, const Block& start, std::span<std::uint8_t> bytes) {
  int written = 0;
  const bool done =
      EVP_EncryptInit_ex2(context, nullptr, key.view().data(), start.data(), nullptr) == 1 &&
      EVP_EncryptUpdate(context, bytes.data(), &written, bytes.data(), static_cast<int>(bytes.size())) == 1;
  return EVP_EncryptInit_ex2(context, nullptr, kNoKey, Block{}.data(), nullptr) == 1 && done;
}

}  // namespace

Ccm::Ccm() = default;
Ccm::Ccm(Ccm&& other) noexcept = default;
Ccm& Ccm::operator=(Ccm&& other) noexcept = default;
Ccm::~Ccm() = default;

Result<void> Ccm::prepare() {
  if (contexts_ != nullptr) return {};
  auto made = std::make_unique<Contexts>();
  if (made->cbc == nullptr || made->ctr == nullptr ||
      EVP_EncryptInit_ex2(made->cbc.get(), EVP_aes_128_cbc(), kNoKey, Block{}.data(), nullptr) != 1 ||
      EVP_CIPHER_CTX_set_padding(made->cbc.get(), 0) != 1 ||
      EVP_EncryptInit_ex2(made->ctr.get(), EVP_aes_128_ctr(), kNoKey, Block{}.data(), nullptr) != 1)
    return openssl_failed("AES-128");
  contexts_ = std::move(made);
  return {};
}

Result<Block> Ccm::mac(const Key& key, const Block& b0, ByteView associated, ByteView content) {
  if (auto prepared = prepare(); !prepared) return fail(prepared.error());
  RUBICON_ASSERT(associated.size() <= 0xffff);
  work_.assign(b0.begin(), b0.end());
  work_.push_back(static_cast<std::uint8_t>(associated.size() >> 8U));
  work_.push_back(static_cast<std::uint8_t>(associated.size() & 0xffU));
  work_.insert(work_.end(), associated.begin(), associated.end());
  work_.insert(work_.end(), content.begin(), content.end());
  work_.resize((work_.size() + 15) / 16 * 16);
  if (!encrypt_once(contexts_->cbc.get(), key, Block{}, work_)) return openssl_failed("AES-128-CBC");
  Block last{};
  std::copy(work_.end() - 16, work_.end(), last.begin());
  return last;
}

Result<void> Ccm::add_key_stream(const Key& key, const Block& c0, std::span<std::uint8_t> mac,
                                 std::span<std::uint8_t> content) {
  if (auto prepared = prepare(); !prepared) return fail(prepared.error());
  work_.assign(mac.begin(), mac.end());
  work_.insert(work_.end(), content.begin(), content.end());
  if (!encrypt_once(contexts_->ctr.get(), key, c0, work_)) return openssl_failed("AES-128-CTR");
  const auto border = work_.begin() + static_cast<std::ptrdiff_t>(mac.size());
  std::copy(work_.begin(), border, mac.begin());
  std::copy(border, work_.end(), content.begin());
  return {};
}

Result<void> Ccm::seal(const Key& key, const Nonce& nonce, ByteView associated, std::span<std::uint8_t> content,
                       std::span<std::uint8_t> mac_out) {
  RUBICON_ASSERT(mac_out.size() <= Block{}.size());
  const auto whole = mac(key, nonce.b0, associated, content);
  if (!whole) return fail(whole.error());
  std::copy_n(whole->begin(), mac_out.size(), mac_out.begin());
  return add_key_stream(key, nonce.c0, mac_out, content);
}

Result<bool> Ccm::open(const Key& key, const Nonce& nonce, ByteView associated, std::span<std::uint8_t> content,
                       ByteView mac_in) {
  RUBICON_ASSERT(mac_in.size() <= Block{}.size());
  Block claimed{};
  std::copy(mac_in.begin(), mac_in.end(), claimed.begin());
  const auto claimed_mac = std::span(claimed).first(mac_in.size());
  if (auto done = add_key_stream(key, nonce.c0, claimed_mac, content); !done) return fail(done.error());
  const auto whole = mac(key, nonce.b0, associated, content);
  if (!whole) return fail(whole.error());
  if (equal(ByteView(*whole).first(mac_in.size()), claimed_mac)) return true;
  wipe(content);
  return false;
}

}  // namespace rubicon::networks::knx::secure
