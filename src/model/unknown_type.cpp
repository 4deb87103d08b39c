#include "model/unknown_type.h"

#include <fmt/format.h>

#include <vector>

#include "base/nearest.h"

namespace rubicon::model {

std::string unknown_type_text(const TypeCatalogue& types, std::string_view name) {
  std::vector<std::string> names;
  for (const auto* type : types.all()) names.emplace_back(type->name);
  const auto near = base::did_you_mean(name, names);
  return fmt::format("unknown type '{}'{} expected one that `rubicon types` lists, or one declared in `types`", name,
                     near.empty() ? "," : "; " + near);
}

}  // namespace rubicon::model
