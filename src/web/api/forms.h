#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "rubicon/client.hpp"
#include "rubicon/tuple.hpp"
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

/// Longer values, and those that are not UTF-8, are not sent with a subscription: a client asks for them by REST.
inline constexpr std::size_t kMaxSentValue = 16UL * 1024;

/// The time that a list shows: of the measurement, else of the write.
WallTime time_of(const TupleView& tuple);
/// What follows the number of a key in the frames of a subscription (docs/api.md): `"686.6",17,1795234047.25`, with
/// `full`, or without the value, a fifth member.
void append_update(const TupleView& tuple, bool full, std::string& out);
/// Everything that is known of a tuple (verbs/answers.h).
nlohmann::ordered_json tuple_json(const client::Tuple& tuple);

/// What a browser may be given of a value that any component wrote: media types that cannot run scripts as they are,
/// all others as bytes.
struct SafeType {
  std::string media_type;
  bool is_shown = false;  ///< false: the browser has to save it to a file
};
SafeType safe_type(std::string_view media_type);

}  // namespace rubicon::web::api
