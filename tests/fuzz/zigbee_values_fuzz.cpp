#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "base/bytes.h"
#include "base/text.h"
#include "fuzz_target.h"
#include "networks/zigbee/exposes/mapping.h"

namespace rubicon::fuzz::zigbee_values_fuzz {

/// Input: an `exposes` array on the first line; after it the JSON of a property, which is also a commanded text. What a
/// device can report can be sent, and is then understood as the same.
FUZZ_TARGET(zigbee_values) {
  using namespace rubicon;
  using namespace rubicon::networks::zigbee::exposes;
  static const TypeCatalogue types;
  const auto text = base::as_text(base::ByteView(data, size));
  const auto line = text.find('\n');
  if (line == text.npos) return 0;
  std::vector<std::string> skipped;
  const auto leaves = read_exposes(text.substr(0, line), skipped);
  if (!leaves) return 0;
  const auto json = text.substr(line + 1);
  for (auto& point : map_leaves(*leaves, types)) {
    point.access.settable = true;
    static_cast<void>(encode(point, Value(std::string(json))));
    static_cast<void>(encode(point, Value(Json{std::string(json)})));
    const auto value = decode(point, json);
    const auto* real = value ? std::get_if<double>(&*value) : nullptr;
    if (real != nullptr && !std::isfinite(*real)) std::abort();
    const auto* tree = value ? std::get_if<Json>(&*value) : nullptr;
    if (tree != nullptr && (base::is_nested_deeper(tree->text, kDeepestJson) || !nlohmann::json::accept(tree->text)))
      std::abort();
    const auto sent = value ? encode(point, *value) : Result<std::string>(std::string());
    if (!value || !sent) continue;
    if (!nlohmann::json::accept(*sent)) std::abort();
    const auto again = decode(point, *sent);
    if (!again) std::abort();
    const auto sent_again = encode(point, *again);
    if (!sent_again || *sent_again != *sent) std::abort();
  }
  return 0;
}

}  // namespace rubicon::fuzz::zigbee_values_fuzz
