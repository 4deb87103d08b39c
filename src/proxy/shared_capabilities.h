#pragma once

#include <cstddef>
#include <memory>
#include <unordered_map>

#include "model/open_type.h"

namespace rubicon::proxy {

/// A capability with the type that it brings, if it brings one (Capability::data).
struct PointCapability : Capability {
  explicit PointCapability(const Capability& capability);

  std::unique_ptr<const model::OpenType> own_type;
};

/// By what the values of the point are read: the type of the catalogue, else that of the capability; nullptr = none.
const Type* type_of(const TypeCatalogue& types, const PointCapability& capability);

/// Shares equal capabilities: thousands of devices of one kind have the same.
class SharedCapabilities {
 public:
  /// Different capabilities beyond this number are not shared.
  static constexpr std::size_t kMax = 2048;

  std::shared_ptr<const PointCapability> of(const Capability& capability);

 private:
  std::unordered_multimap<std::size_t, std::weak_ptr<const PointCapability>> known_;  ///< by a hash of the point
};

}  // namespace rubicon::proxy
