#pragma once

#include <vector>

#include "bridges/mqtt/entities.h"

namespace rubicon::bridges::mqtt {

using Points = std::vector<const PointEntry*>;

/// Lights, covers, thermostats, locks, valves, fans and sirens, each made of one or several of the points that can be
/// commanded; they take what they use out of `written`, and of `left` what a thermostat shows.
std::vector<Entity> composites_of(Points& written, Points& left);

/// The second word of a boolean: `on`, `open`, `locked`.
std::string on_word(const PointEntry& point);
/// The topics of what can be commanded and shows its state. Never optimistic: only what is reported is shown.
nlohmann::ordered_json commanded(const PointEntry& point);
std::string entity_id(const PointEntry& point);

}  // namespace rubicon::bridges::mqtt
