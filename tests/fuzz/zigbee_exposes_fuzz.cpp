#include <cstdlib>
#include <set>

#include "base/bytes.h"
#include "fuzz_target.h"
#include "model/type_names.h"
#include "networks/zigbee/exposes/mapping.h"
#include "rubicon/key.hpp"

namespace rubicon::fuzz::zigbee_exposes_fuzz {

/// Input: an `exposes` array. Each leaf becomes a point whose id is unique, also as part of a key.
FUZZ_TARGET(zigbee_exposes) {
  using namespace rubicon;
  using namespace rubicon::networks::zigbee::exposes;
  static const TypeCatalogue types;
  std::vector<std::string> skipped;
  const auto leaves = read_exposes(base::as_text(base::ByteView(data, size)), skipped);
  if (!leaves) return 0;
  const auto points = map_leaves(*leaves, types);
  if (points.size() < leaves->size() || points != map_leaves(*leaves, types)) std::abort();
  std::set<PointId> ids;
  std::set<std::string> keys;
  for (const auto& point : points) {
    const auto& [kind, type, instance] = point.capability.point;
    if (!instance.empty() && model::to_key_part(instance) != instance) std::abort();
    auto key = std::string(model::to_string(kind)) + model::name_in_keys(point.capability) + '-' + instance;
    if (!ids.insert(point.capability.point).second || !keys.insert(std::move(key)).second) std::abort();
    for (const auto* json : {"1", "-0.5", "null", "\"ON\"", "true", "{\"x\":1,\"y\":0}", "[]"})
      static_cast<void>(decode(point, json));
  }
  static_cast<void>(unknown_units(*leaves));
  return 0;
}

}  // namespace rubicon::fuzz::zigbee_exposes_fuzz
