#include "island/island_presence.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "model/json_members.h"
#include "model/json_text.h"
#include "model/point_keys.h"
#include "transport/host_name.h"

namespace rubicon::island {

namespace {

/// While networks start, much changes at once, and a reader may be there already.
constexpr Duration kFirstPause = std::chrono::milliseconds(10);
constexpr Duration kPresencePause = std::chrono::seconds(1);

}  // namespace

IslandPresence::IslandPresence(Scheduler& scheduler, TupleSpace& space, std::string name, std::string prefix,
                               Count count)
    : scheduler_(scheduler),
      space_(space),
      count_(std::move(count)),
      summary_{std::move(name), transport::host_name(), "rubicon-proxy " RUBICON_VERSION, std::move(prefix),
               scheduler.wall_now()} {}

void IslandPresence::start() {
  pause_ = kFirstPause;
  refresh();
}

void IslandPresence::refresh() {
  timer_ = scheduler_.after(pause_, [this] { refresh(); });
  pause_ = std::min(2 * pause_, kPresencePause);
  summary_.networks = count_();
  auto text = model::to_json(summary_);
  if (text != described_ && space_.describe(text)) described_ = std::move(text);
  list_islands();
}

void IslandPresence::list_islands() {
  auto text = islands();
  if (text == listed_) return;
  listed_ = std::move(text);
  std::ignore = space_.set(model::IslandKey{summary_.prefix}.islands(), listed_, {"application/json"});
}

/// JSON; each entry is the island's own summary and its id.
std::string IslandPresence::islands() const {
  auto list = nlohmann::ordered_json::array();
  for (const auto id : space_.peers()) {
    const auto summary = model::summary_from_json(space_.summary(id)).value_or(Summary{});
    if (!model::is_island(id, summary)) continue;
    nlohmann::ordered_json entry{{"id", number(id)}};
    entry.update(model::parse_ordered_json(model::to_json(summary)));
    list.push_back(std::move(entry));
  }
  return model::dump(list);
}

}  // namespace rubicon::island
