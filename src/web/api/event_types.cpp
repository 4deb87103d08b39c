#include "web/api/event_types.h"

#include "model/point_keys.h"
#include "model/point_tuples.h"

namespace rubicon::web::api {

Sets EventTypes::sets_of(OwnerId owner, std::string_view key) {
  if (!key.ends_with(".value") || !model::point_of(key)) return Sets::kStates;
  const auto id = model::last_part(model::parent_key(key));
  const auto type = id.substr(0, id.find('-'));
  if (const auto* known = catalogue_.find(type))
    return known->report == model::Report::kEvent ? Sets::kEvents : Sets::kStates;
  return is_open_event(owner, key, type) ? Sets::kEvents : Sets::kUnknown;
}

bool EventTypes::is_open_event(OwnerId owner, std::string_view key, std::string_view type) {
  const auto name = std::pair(owner, std::string(type));
  const auto known = open_types_.find(name);
  if (known != open_types_.end()) return known->second.is_event;
  if (open_types_.size() >= kMaxOpenTypes) return false;
  auto& open = open_types_[name];
  open.description = space_.subscribe({owner, model::point_of(key)->description()}, {.passive = true},
                                      [&open](const tuples::Event& event) {
                                        const auto about = model::point_description_from_json(event.tuple.value);
                                        if (about) open.is_event = about->report == "event";
                                      });
  return false;
}

}  // namespace rubicon::web::api
