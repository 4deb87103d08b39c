#pragma once

#include <cstdint>
#include <memory>
#include <vector>

namespace rubicon::tuples {

/// A vector that grows by pages: elements never move, and at most one page is unused, whereas a std::vector may reserve
/// twice its size.
template <class T>
class Pages {
 public:
  T& operator[](std::uint32_t index) { return pages_[index / kPage][index % kPage]; }
  const T& operator[](std::uint32_t index) const { return pages_[index / kPage][index % kPage]; }
  std::uint32_t size() const { return size_; }
  /// Returns the index of the new element.
  std::uint32_t add() {
    if (size_ % kPage == 0) pages_.push_back(std::make_unique<T[]>(kPage));
    return size_++;
  }

 private:
  static constexpr std::uint32_t kPage = 256;

  std::vector<std::unique_ptr<T[]>> pages_;
  std::uint32_t size_ = 0;
};

}  // namespace rubicon::tuples
