#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "networks/knx/secure/key.h"
#include "rubicon/result.hpp"

namespace rubicon::networks::knx::secure {

/// The primitives of KNX Secure, all of them of OpenSSL (knx.md, section 10.1; KNX 3/8/9 for IP, 3/3/7 for data). Every
/// function fails with kIo if OpenSSL reports an error: it lacks the algorithm, or memory.

using Block = std::array<std::uint8_t, 16>;
using Digest = std::array<std::uint8_t, 32>;
/// A public key of X25519.
using PublicKey = std::array<std::uint8_t, 32>;

/// Fills the span with unpredictable bytes. Tests replace it to get known keys.
using Random = std::function<Result<void>(std::span<std::uint8_t>)>;
/// The random generator of OpenSSL.
Random system_random();

/// PBKDF2-HMAC-SHA256 with 65,536 rounds: some 15 ms, so that callers run it off the event loop.
Result<Key> key_of_password(ByteView password, std::string_view salt);
/// The same with `size` bytes.
Result<Secret> secret_of_password(ByteView password, std::string_view salt, std::size_t size);
/// In base64 (RFC 4648, section 4).
Secret base64_of(ByteView bytes);

Result<Digest> sha256(ByteView bytes);

/// Equal content, compared in constant time.
bool equal(ByteView left, ByteView right);

/// Private and public key of X25519, one pair for each session.
class KeyPair {
 public:
  static Result<KeyPair> make(const Random& random);
  /// The pair of a private key of 32 bytes.
  static Result<KeyPair> of(Secret private_key);

  const PublicKey& public_key() const { return public_; }
  /// The secret of 32 bytes that both ends compute. kInvalid for a key of the peer that gives zeros (RFC 7748, 6.1).
  Result<Secret> shared_with(const PublicKey& peer) const;

 private:
  KeyPair(Secret private_key, const PublicKey& public_key) : private_(std::move(private_key)), public_(public_key) {}

  Secret private_;
  PublicKey public_;
};

/// AES-128-CBC without padding; the content is as long as `encrypted`. kInvalid unless that is a multiple of 16.
Result<Secret> decrypt_cbc(const Key& key, const Block& start, ByteView encrypted);
/// The inverse, for generators of test files.
Result<Bytes> encrypt_cbc(const Key& key, const Block& start, ByteView content);

/// The two blocks that make each use of a key unique.
struct Nonce {
  Block b0{}, c0{};
};

/// CCM as KNX builds it: the MAC is the last block of AES-CBC, from zeros, over B0, the length of A in two bytes, A, P
/// and zeros up to a whole block. AES-CTR from C0 then encrypts the MAC and, behind it, P. It is not the CCM of RFC
/// 3610. Its contexts are used again; between two calls they hold no key.
class Ccm {
 public:
  Ccm();
  Ccm(Ccm&& other) noexcept;
  Ccm& operator=(Ccm&& other) noexcept;
  ~Ccm();

  /// The MAC before AES-CTR.
  Result<Block> mac(const Key& key, const Block& b0, ByteView associated, ByteView content);
  /// Encrypts `content` where it is and writes the encrypted MAC: its first mac.size() bytes (16, or 4 for Data
  /// Secure).
  Result<void> seal(const Key& key, const Nonce& nonce, ByteView associated, std::span<std::uint8_t> content,
                    std::span<std::uint8_t> mac);
  /// Decrypts `content` where it is. False: the MAC is wrong, and `content` was overwritten with zeros.
  Result<bool> open(const Key& key, const Nonce& nonce, ByteView associated, std::span<std::uint8_t> content,
                    ByteView mac);

 private:
  struct Contexts;

  Result<void> prepare();
  Result<void> add_key_stream(const Key& key, const Block& c0, std::span<std::uint8_t> mac,
                              std::span<std::uint8_t> content);

  std::unique_ptr<Contexts> contexts_;
  Bytes work_;  ///< its memory is used again
};

}  // namespace rubicon::networks::knx::secure
