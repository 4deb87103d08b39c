#pragma once

#include <cstddef>
#include <memory>
#include <unordered_map>

#include "model/point.h"

namespace rubicon::proxy {

/// Shares equal capabilities: thousands of devices of one kind have the same.
class SharedCapabilities {
 public:
  /// Different capabilities beyond this number are not shared.
  static constexpr std::size_t kMax = 2048;

  std::shared_ptr<const Capability> of(const Capability& capability);

 private:
  std::unordered_multimap<std::size_t, std::weak_ptr<const Capability>> known_;  ///< by a hash of the point
};

}  // namespace rubicon::proxy
