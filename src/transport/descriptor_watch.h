#pragma once

#include <functional>
#include <memory>

namespace rubicon::transport {

/// Tells when a descriptor is ready: each wait brings one call of the loop, in a later turn. Destroying it ends the
/// waits; the descriptor, which its user owns, is closed after that.
class DescriptorWatch {
 public:
  virtual ~DescriptorWatch() = default;
  virtual void await_readable() = 0;
  virtual void await_room() = 0;
};

struct DescriptorCalls {
  std::function<void()> readable, room;
};

/// How a loop watches descriptors.
using WatchDescriptor = std::function<std::unique_ptr<DescriptorWatch>(int descriptor, DescriptorCalls calls)>;

}  // namespace rubicon::transport
