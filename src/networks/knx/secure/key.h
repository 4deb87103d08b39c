#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "base/bytes.h"

namespace rubicon::networks::knx::secure {

/// Bytes that only their owner may see: a password, a private key, a decrypted value. They lie in the secure heap of
/// OpenSSL (excluded from core dumps, locked where the system permits it, 4 MiB; further secrets lie in ordinary
/// memory) and are overwritten at destruction. There is no conversion to a string and no output operator. Threads may
/// have secrets of their own.
class Secret {
 public:
  Secret() = default;
  /// `size` zero bytes.
  explicit Secret(std::size_t size);
  /// A copy. The caller overwrites the original (wipe()).
  explicit Secret(ByteView bytes);
  /// A copy of a text in any encoding.
  static Secret of_text(std::string_view text);
  Secret(const Secret& other);
  Secret& operator=(const Secret& other);
  Secret(Secret&& other) noexcept;
  Secret& operator=(Secret&& other) noexcept;
  ~Secret() = default;

  ByteView view() const { return {bytes_.get(), size_}; }
  std::span<std::uint8_t> span() { return {bytes_.get(), size_}; }
  std::string_view text() const { return base::as_text(view()); }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }

  /// In constant time for secrets of the same size.
  friend bool operator==(const Secret& left, const Secret& right);

 private:
  struct Free {
    std::size_t size;
    void operator()(std::uint8_t* bytes) const;
  };

  std::unique_ptr<std::uint8_t[], Free> bytes_;
  std::size_t size_ = 0;
};

/// A key of AES-128.
class Key {
 public:
  static constexpr std::size_t kSize = 16;

  /// All zero.
  Key() : bytes_(kSize) {}
  /// A copy of the first kSize bytes; `bytes` must have as many.
  explicit Key(ByteView bytes);
  /// kInvalid, without the bytes in the text, unless there are kSize.
  static Result<Key> from(ByteView bytes);

  /// Empty after the key was moved away.
  ByteView view() const { return bytes_.view(); }
  std::span<std::uint8_t> span() { return bytes_.span(); }

  /// In constant time.
  friend bool operator==(const Key&, const Key&) = default;

 private:
  Secret bytes_;
};

/// Overwrites memory so that no compiler removes it.
void wipe(std::span<std::uint8_t> bytes);
/// Overwrites a text that held a secret, and makes it empty.
void wipe(std::string& text);

}  // namespace rubicon::networks::knx::secure
