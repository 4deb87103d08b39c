#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "model/type_catalogue.h"
#include "rubicon/tuple_space.hpp"

namespace rubicon::web::api {

/// What the sets of a tuple are.
enum class Sets : std::uint8_t {
  kUnknown,  ///< an open type without a description of events so far: they count as states
  kStates,   ///< only the latest counts
  kEvents,   ///< each one counts (button, scene)
};

/// Tells which tuples hold events and which states; only the values of points may hold events.
/// Learns open types, which the catalogue does not know, from the description of one point of each.
class EventTypes {
 public:
  explicit EventTypes(TupleSpace& space) : space_(space) {}

  /// Other than kUnknown, the answer for a key is final.
  Sets sets_of(OwnerId owner, std::string_view key);

 private:
  /// Open types that are known at a time; the points of others count as states.
  static constexpr std::size_t kMaxOpenTypes = 4096;
  struct OpenType {
    bool is_event = false;
    tuples::Handle description;
  };
  bool is_open_event(OwnerId owner, std::string_view key, std::string_view type);

  TupleSpace& space_;
  model::TypeCatalogue catalogue_;
  std::map<std::pair<OwnerId, std::string>, OpenType, std::less<>> open_types_;
};

}  // namespace rubicon::web::api
