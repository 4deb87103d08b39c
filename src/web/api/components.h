#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "rubicon/tuple_space.hpp"

namespace rubicon::web::api {

/// A component as `rubicon islands --json` shows it, with `version` apart from `program`.
nlohmann::ordered_json component_json(OwnerId id, std::string_view summary);
/// The components that are present, by id; with `islands_only` the islands among them.
nlohmann::ordered_json components_json(const TupleSpace& space, bool islands_only);
/// Which tuples are those of islands. For one turn: each island is asked for its prefix once.
class IslandPrefixes {
 public:
  explicit IslandPrefixes(const TupleSpace& space) : space_(space) {}

  /// An island owns the tuple, and its key begins with the prefix that the island describes.
  bool fit(OwnerId owner, std::string_view key);

 private:
  const TupleSpace& space_;
  std::map<OwnerId, std::string> beginnings_;  ///< `proxy.`; empty: it has none
};

}  // namespace rubicon::web::api
