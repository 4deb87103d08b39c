#pragma once

#include <cstddef>
#include <memory>
#include <unordered_map>

#include "model/point.h"

namespace rubicon::proxy {

/// Capabilities, those that are alike once: devices of one kind have the same, and there may be thousands of them.
class SharedCapabilities {
 public:
  /// More different ones than these are not looked for any more.
  static constexpr std::size_t kMost = 2048;

  std::shared_ptr<const Capability> of(const Capability& capability);

 private:
  std::unordered_multimap<std::size_t, std::weak_ptr<const Capability>> known_;  ///< by a hash of the point
};

}  // namespace rubicon::proxy
