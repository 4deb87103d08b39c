#pragma once

#include <unistd.h>

#include <utility>

namespace rubicon::transport {

/// A file descriptor that is closed when this object is destroyed, unless it was taken. Negative: none.
class OwnDescriptor {
 public:
  explicit OwnDescriptor(int number) : number_(number) {}
  ~OwnDescriptor() {
    if (number_ >= 0) ::close(number_);
  }
  OwnDescriptor(OwnDescriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  OwnDescriptor& operator=(OwnDescriptor&&) = delete;
  int get() const { return number_; }
  int take() { return std::exchange(number_, -1); }

 private:
  int number_;
};

}  // namespace rubicon::transport
