#include "proxy/shared_capabilities.h"

#include <functional>
#include <string>

namespace rubicon::proxy {

PointCapability::PointCapability(const Capability& capability)
    : Capability(capability), own_type(capability.data ? std::make_unique<model::OpenType>(capability) : nullptr) {}

const Type* type_of(const TypeCatalogue& types, const PointCapability& capability) {
  if (const auto* known = types.find(capability.point.type)) return known;
  return capability.own_type ? &capability.own_type->type() : nullptr;
}

std::shared_ptr<const PointCapability> SharedCapabilities::of(const Capability& capability) {
  const auto hash =
      std::hash<std::string>{}(capability.point.instance) * 31 + static_cast<std::size_t>(capability.point.type);
  const auto [first, last] = known_.equal_range(hash);
  for (auto one = first; one != last; ++one) {
    if (auto known = one->second.lock(); known && static_cast<const Capability&>(*known) == capability) return known;
  }
  if (known_.size() >= kMax) std::erase_if(known_, [](const auto& one) { return one.second.expired(); });
  auto fresh = std::make_shared<const PointCapability>(capability);
  if (known_.size() < kMax) known_.emplace(hash, fresh);
  return fresh;
}

}  // namespace rubicon::proxy
