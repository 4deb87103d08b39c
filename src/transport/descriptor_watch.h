#pragma once

#include <unistd.h>

#include <functional>
#include <memory>
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

/// Tells when a descriptor is ready: each wait brings one call of the loop, in a later turn. Destroying it ends the
/// waits; the descriptor, which its user owns, is closed after that.
class DescriptorWatch {
 public:
  virtual ~DescriptorWatch() = default;
  virtual void await_readable() = 0;
  virtual void await_room() = 0;
};

struct DescriptorCallbacks {
  std::function<void()> readable, room;
};

/// How a loop watches descriptors.
using WatchDescriptor = std::function<std::unique_ptr<DescriptorWatch>(int descriptor, DescriptorCallbacks calls)>;

}  // namespace rubicon::transport
