#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <type_traits>

#include "base/assert.h"

namespace rubicon::motes {

/// A list of at most kMax trivially copyable values without heap memory, so that records are decoded without
/// allocating. Asserts that it does not overflow.
template <typename T, std::size_t kMax>
class InlineArray {
  static_assert(std::is_trivially_copyable_v<T> && kMax <= 255);

 public:
  InlineArray() = default;
  InlineArray(std::initializer_list<T> values) {
    for (const T& value : values) push_back(value);
  }

  void push_back(const T& value) {
    RUBICON_ASSERT(size_ < kMax);
    values_[size_++] = value;
  }

  static constexpr std::size_t capacity() { return kMax; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const T& operator[](std::size_t index) const {
    RUBICON_ASSERT(index < size_);
    return values_[index];
  }
  const T& front() const { return (*this)[0]; }
  const T& back() const { return (*this)[size_ - 1]; }
  T& back() {
    RUBICON_ASSERT(size_ > 0);
    return values_[size_ - 1U];
  }
  const T* begin() const { return values_.data(); }
  const T* end() const { return values_.data() + size_; }

  friend bool operator==(const InlineArray& a, const InlineArray& b) {
    if (a.size_ != b.size_) return false;
    for (std::size_t i = 0; i < a.size_; ++i) {
      if (!(a.values_[i] == b.values_[i])) return false;
    }
    return true;
  }

 private:
  std::array<T, kMax> values_{};
  std::uint8_t size_ = 0;  // small, because the arrays are nested
};

}  // namespace rubicon::motes
