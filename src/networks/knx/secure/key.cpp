#include "networks/knx/secure/key.h"

#include <fmt/format.h>
#include <openssl/crypto.h>

#include <algorithm>
#include <utility>

#include "base/assert.h"

namespace rubicon::networks::knx::secure {

namespace {

constexpr std::size_t kSecureHeap = std::size_t{4} << 20U, kMinBlock = 16;

/// Another part of the program may have made the secure heap before; one without it can only use ordinary memory.
bool make_secure_heap() {
  return CRYPTO_secure_malloc_initialized() != 0 || CRYPTO_secure_malloc_init(kSecureHeap, kMinBlock) != 0;
}

std::uint8_t* allocate(std::size_t size) {
  static const bool kHasSecureHeap = make_secure_heap();
  void* memory = kHasSecureHeap ? OPENSSL_secure_zalloc(size) : nullptr;
  if (memory == nullptr) memory = OPENSSL_zalloc(size);
  RUBICON_ASSERT(memory != nullptr);
  return static_cast<std::uint8_t*>(memory);
}

}  // namespace

void Secret::Free::operator()(std::uint8_t* bytes) const {
  OPENSSL_secure_clear_free(bytes, size);
}

Secret::Secret(std::size_t size) : size_(size) {
  if (size > 0) bytes_ = {allocate(size), Free{size}};
}

Secret::Secret(ByteView bytes) : Secret(bytes.size()) {
  std::copy(bytes.begin(), bytes.end(), bytes_.get());
}

Secret Secret::of_text(std::string_view text) {
  return Secret(base::as_bytes(text));
}

Secret::Secret(const Secret& other) : Secret(other.view()) {}

Secret& Secret::operator=(const Secret& other) {
  if (this != &other) *this = Secret(other);
  return *this;
}

Secret::Secret(Secret&& other) noexcept : bytes_(std::move(other.bytes_)), size_(std::exchange(other.size_, 0)) {}

Secret& Secret::operator=(Secret&& other) noexcept {
  bytes_ = std::move(other.bytes_);
  size_ = std::exchange(other.size_, 0);
  return *this;
}

bool operator==(const Secret& left, const Secret& right) {
  return left.size_ == right.size_ &&
         (left.empty() || CRYPTO_memcmp(left.bytes_.get(), right.bytes_.get(), left.size_) == 0);
}

Key::Key(ByteView bytes) : bytes_(bytes.first(kSize)) {
  RUBICON_ASSERT(bytes.size() >= kSize);
}

Result<Key> Key::from(ByteView bytes) {
  if (bytes.size() != kSize)
    return fail(ErrorCode::kInvalid, fmt::format("key of {} bytes, expected {}", bytes.size(), kSize));
  return Key(bytes);
}

void wipe(std::span<std::uint8_t> bytes) {
  if (!bytes.empty()) OPENSSL_cleanse(bytes.data(), bytes.size());
}

void wipe(std::string& text) {
  text.resize(text.capacity());  // what shorter contents left behind as well
  if (!text.empty()) OPENSSL_cleanse(text.data(), text.size());
  text.clear();
}

}  // namespace rubicon::networks::knx::secure
