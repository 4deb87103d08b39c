#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/text.h"
#include "model/point_keys.h"
#include "web/api/metrics_text.h"
#include "web/api/route.h"
#include "web/api/tuple_read.h"

namespace rubicon::web::api {

namespace {

/// Prometheus text format, version 0.0.4.
constexpr const char* kMediaType = "text/plain; version=0.0.4";

void add_own(const Context::Counters& counters, const TupleSpace::Stats& stats, MetricsText& text) {
  const std::array<std::pair<std::string_view, std::uint64_t>, 8> totals{{{"requests", counters.requests},
                                                                          {"errors", counters.errors},
                                                                          {"frames_received", counters.frames_in},
                                                                          {"frames_sent", counters.frames_out},
                                                                          {"sent_bytes", counters.bytes_out},
                                                                          {"commands", counters.commands},
                                                                          {"busy", counters.busy},
                                                                          {"lost_events", counters.lost_events}}};
  for (const auto& [name, count] : totals)
    text.add(fmt::format("rubicon_web_{}_total", name), "counter", {}, std::to_string(count));
  const std::array<std::pair<std::string_view, std::size_t>, 4> amounts{{{"websockets", counters.conversations},
                                                                         {"event_streams", counters.streams},
                                                                         {"subscriptions", counters.subscriptions},
                                                                         {"cached_tuples", stats.cached}}};
  for (const auto& [name, count] : amounts)
    text.add(fmt::format("rubicon_web_{}", name), "gauge", {}, std::to_string(count));
}

void add_history(const history::Counters& counters, MetricsText& text) {
  const std::array<std::pair<std::string_view, std::uint64_t>, 3> totals{
      {{"points", counters.points}, {"dropped_points", counters.dropped}, {"failures", counters.failures}}};
  for (const auto& [name, count] : totals)
    text.add(fmt::format("rubicon_history_{}_total", name), "counter", {}, std::to_string(count));
  text.add("rubicon_history_bytes", "gauge", {}, std::to_string(counters.bytes));
  text.add("rubicon_history_recording", "gauge", {}, counters.recording ? "1" : "0");
}

/// Numbers as they are; switches as 1 and 0. Empty: the value has no number.
std::string number_of_value(std::string_view value) {
  if (base::parse_number<double>(value)) return std::string(value);
  if (value == "on" || value == "true" || value == "open") return "1";
  if (value == "off" || value == "false" || value == "closed") return "0";
  return {};
}

void add_values(const std::vector<client::Tuple>& tuples, const std::vector<Pattern>& patterns, MetricsText& text) {
  for (const auto& tuple : tuples) {
    const auto is_asked = [&tuple](const Pattern& pattern) { return pattern.matches(tuple.owner, tuple.key); };
    if (std::none_of(patterns.begin(), patterns.end(), is_asked)) continue;
    const auto number = number_of_value(tuple.value);
    if (number.empty()) continue;
    MetricsText::Labels labels{{"island", std::to_string(model::number(tuple.owner))}};
    const auto parts = model::key_parts(tuple.key);
    if (model::point_of(tuple.key)) {
      constexpr std::array<const char*, 4> kLabels{"network", "device", "kind", "point"};
      for (std::size_t i = 0; i < kLabels.size(); ++i) labels.emplace_back(kLabels[i], std::string(parts[i + 1]));
    } else {
      labels.emplace_back("key", tuple.key);
    }
    text.add("rubicon_value", "gauge", labels, number);
  }
}

std::vector<Pattern> island_patterns() {
  const model::IslandKey island{"*"};
  const auto network = island.network("*");
  return {{std::nullopt, network.status()},
          {std::nullopt, network.device("*").status()},
          {std::nullopt, network.property("*")},
          {std::nullopt, island.property("*")}};
}

}  // namespace

std::unique_ptr<Exchange> metrics(Call& call) {
  if (auto good = call.may_read({std::nullopt, "**"}); !good) return call.refuse(good.error());
  auto patterns = island_patterns();
  const auto& asked = call.context.options.metrics_patterns;
  patterns.insert(patterns.end(), asked.begin(), asked.end());
  for (const auto& pattern : patterns) call.context.recent_reads.keep(pattern);
  return call.read(patterns, [&context = call.context](const std::vector<client::Tuple>& tuples) {
    MetricsText text;
    add_island_metrics(tuples, text);
    add_values(tuples, context.options.metrics_patterns, text);
    add_own(context.counters, context.space.stats(), text);
    if (context.options.history) add_history(context.options.history->counters(), text);
    return Response{.status = 200, .content_type = kMediaType, .body = text.text(), .headers = {}, .stream = {}};
  });
}

}  // namespace rubicon::web::api
