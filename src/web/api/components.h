#pragma once

#include <nlohmann/json.hpp>

#include "rubicon/tuple_space.hpp"

namespace rubicon::web::api {

/// A component as `rubicon islands --json` shows it, with `version` apart from `program`.
nlohmann::ordered_json component_json(OwnerId id, std::string_view summary);
/// The components that are present, by id; with `islands_only` the islands among them.
nlohmann::ordered_json components_json(const TupleSpace& space, bool islands_only);

}  // namespace rubicon::web::api
