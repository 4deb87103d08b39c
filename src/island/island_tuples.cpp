#include "island/island_tuples.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "base/log.h"
#include "base/text.h"
#include "model/json_members.h"
#include "model/json_text.h"
#include "model/point_keys.h"
#include "transport/host_names.h"

namespace rubicon::island {

namespace {

constexpr Duration kMetricsPause = std::chrono::seconds(1);

}  // namespace

IslandMetrics::IslandMetrics(Scheduler& scheduler, TupleSpace& space, std::string prefix)
    : scheduler_(scheduler), space_(space), prefix_(std::move(prefix)) {}

void IslandMetrics::start() {
  const auto clock = model::IslandKey{prefix_}.property("clock");
  std::ignore = space_.declare(clock);
  clock_watch_ = space_.watch_demand({space_.self(), clock}, [this](const tuples::Demand& demand) {
    clock_wanted_ = demand.wanted;
    if (clock_wanted_) publish_clock();
  });
  publish();
}

void IslandMetrics::publish() {
  timer_ = scheduler_.after(kMetricsPause, [this] { publish(); });
  std::map<std::string, std::string> now;
  for (const auto& source : sources_) source(Publish(now));
  for (const auto& [name, value] : now) {
    const auto before = published_.find(name);
    if (before != published_.end() && before->second == value) continue;
    std::ignore = space_.set(model::IslandKey{prefix_}.property(name), value);
  }
  for (const auto& [name, value] : published_) {
    if (!now.contains(name)) std::ignore = space_.erase(model::IslandKey{prefix_}.property(name));
  }
  published_ = std::move(now);
  if (clock_wanted_) publish_clock();
}

void IslandMetrics::publish_clock() {
  std::ignore = space_.set(model::IslandKey{prefix_}.property("clock"),
                           fmt::format("{:.6f}", base::to_seconds(scheduler_.wall_now())));
}

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

namespace {

std::string_view word_of(base::LogLevel level) {
  switch (level) {
    case base::LogLevel::kDebug: return "debug";
    case base::LogLevel::kInfo: return "info";
    case base::LogLevel::kWarning: return "warning";
    case base::LogLevel::kError: break;
  }
  return "error";
}

/// At most so many bytes, cut after a character.
std::string cut(std::string_view text, std::size_t most) {
  return std::string(text.substr(0, base::utf8_prefix(text.substr(0, most))));
}

}  // namespace

void LogLines::write(base::LogLevel level, std::string_view who, std::string_view text) {
  behind_.write(level, who, text);
  if (level < least_) return;
  // The mask comes before the cut: half a password would not be recognized behind it.
  lines_.push_back({++written_, clock_.wall_now(), level, cut(base::one_line(who), kMaxSubject),
                    cut(base::masked(base::one_line(text)), kMaxTextCount)});
  if (lines_.size() > kKept) lines_.pop_front();
  if (call_) call_();
}

std::string LogLines::json() const {
  auto list = nlohmann::ordered_json::array();
  for (const auto& line : lines_) {
    list.push_back({{"number", line.number},
                    {"time", model::seconds_json(line.time)},
                    {"level", word_of(line.level)},
                    {"subject", line.subject},
                    {"text", line.text}});
  }
  return model::dump(list);
}

namespace {

constexpr Duration kLogPause = std::chrono::milliseconds(250);
/// Between two looks whether a passive subscriber came for lines that are not published yet.
constexpr Duration kLook = std::chrono::seconds(1);

}  // namespace

LogTuples::LogTuples(Scheduler& scheduler, TupleSpace& space, std::string key, LogLines& lines)
    : scheduler_(scheduler), space_(space), key_(std::move(key)), lines_(lines), publish_(scheduler, kLogPause, [this] {
        publish_if_wanted();
      }) {
  publish();
  lines_.on_line([this] { publish_.request(); });
  demand_ = space_.watch_demand({space_.self(), key_}, [this](const tuples::Demand& demand) {
    if (demand.wanted) publish_.call_now();
  });
}

void LogTuples::publish_if_wanted() {
  const auto tuple = space_.find(key_);
  if (tuple && space_.has_subscriber(*tuple)) return publish();
  look_again_ = scheduler_.after(kLook, [this] { publish_.request(); });
}

void LogTuples::publish() {
  look_again_.cancel();
  std::ignore = space_.set(key_, lines_.json(), {"application/json", {}, {}});
}

}  // namespace rubicon::island
