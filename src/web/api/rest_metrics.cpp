#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.h"
#include "client/tuple_query.h"
#include "model/point_keys.h"
#include "model/point_tuples.h"
#include "web/api/route.h"

namespace rubicon::web::api {

/// Collects samples and writes them in the Prometheus text format 0.0.4: each metric once, with its type, the samples
/// behind it.
class MetricsText {
 public:
  using Labels = std::vector<std::pair<std::string_view, std::string>>;

  /// `name` may hold any characters; those that a metric may not become `_`.
  void add(std::string_view name, std::string_view type, const Labels& labels, std::string_view number);
  std::string text() const;

 private:
  struct Metric {
    std::string type;
    std::vector<std::string> samples;
  };
  std::map<std::string, Metric> metrics_;
};

/// What the tuples of islands say: lines, devices by status, and counters (docs/api.md).
void add_island_metrics(const std::vector<client::Tuple>& tuples, MetricsText& text);

namespace {

using Labels = MetricsText::Labels;

std::string metric_name(std::string_view name) {
  std::string good;
  for (const char c : name) good += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return good;
}

std::string escaped(std::string_view text) {
  std::string good;
  for (const char c : text) {
    if (c == '\\' || c == '"') good += '\\';
    if (c == '\n') {
      good += "\\n";
    } else {
      good += c;
    }
  }
  return good;
}

std::string island_of(const client::Tuple& tuple) {
  return std::to_string(number(tuple.owner));
}

bool is_number(std::string_view text) {
  const auto number = base::parse_number<double>(text);
  return number && std::isfinite(*number);
}

/// Properties that rise and fall: amounts that are present, not counts since the start.
bool is_amount(std::string_view name) {
  constexpr std::array<std::string_view, 12> kLast{"cached",  "subscriptions", "queued", "waiting",
                                                   "ignored", "devices",       "bytes",  "files",
                                                   "clients", "attempt",       "clock",  "speed"};
  const auto last = name.substr(name.rfind('-') + 1);
  return std::find(kLast.begin(), kLast.end(), last) != kLast.end();
}

/// `recorder-all-night-records`: `records` of the recorder `all-night`.
void add_recorder(std::string_view name, Labels labels, std::string_view value, MetricsText& text) {
  constexpr std::string_view kFreeBytes = "-free-bytes";
  name.remove_prefix(std::string_view("recorder-").size());
  const auto end = name.ends_with(kFreeBytes) ? name.size() - kFreeBytes.size() : name.rfind('-');
  if (end >= name.size()) return;
  labels.emplace_back("recorder", std::string(name.substr(0, end)));
  const auto what = name.substr(end + 1);
  const bool amount = is_amount(what);
  text.add(fmt::format("rubicon_recorder_{}{}", what, amount ? "" : "_total"), amount ? "gauge" : "counter", labels,
           value);
}

void add_property(std::string_view name, const Labels& labels, std::string_view value, MetricsText& text) {
  if (!is_number(value) || name == "devices") return;
  if (name.starts_with("recorder-")) return add_recorder(name, labels, value, text);
  const bool is_count = !is_amount(name) && base::parse_number<std::uint64_t>(value).has_value();
  text.add(fmt::format("rubicon_{}{}", name, is_count ? "_total" : ""), is_count ? "counter" : "gauge", labels, value);
}

void add_line(const client::Tuple& tuple, std::string_view network, MetricsText& text) {
  const auto line = model::line_status_from_json(tuple.value);
  if (line.line.empty()) return;
  text.add("rubicon_network_line_up", "gauge", {{"island", island_of(tuple)}, {"network", std::string(network)}},
           line.line == "up" ? "1" : "0");
}

}  // namespace

void MetricsText::add(std::string_view name, std::string_view type, const Labels& labels, std::string_view number) {
  const auto good = metric_name(name);
  auto& metric = metrics_[good];
  metric.type = type;
  std::string list;
  for (const auto& [label, value] : labels)
    list += fmt::format("{}{}=\"{}\"", list.empty() ? "" : ",", label, escaped(value));
  metric.samples.push_back(list.empty() ? fmt::format("{} {}\n", good, number)
                                        : fmt::format("{}{{{}}} {}\n", good, list, number));
}

std::string MetricsText::text() const {
  std::string text;
  for (const auto& [name, metric] : metrics_) {
    text += fmt::format("# TYPE {} {}\n", name, metric.type);
    for (const auto& sample : metric.samples) text += sample;
  }
  return text;
}

void add_island_metrics(const std::vector<client::Tuple>& tuples, MetricsText& text) {
  std::map<std::array<std::string, 3>, std::size_t> devices;  // by island, network, status
  for (const auto& tuple : tuples) {
    const auto parts = model::key_parts(tuple.key);
    const auto is = [&parts](std::size_t count, std::size_t place, std::string_view word) {
      return parts.size() == count && parts[place] == word;
    };
    if (is(3, 2, "status")) {
      add_line(tuple, parts[1], text);
    } else if (is(4, 3, "status")) {
      const auto status = model::device_condition_from_json(tuple.value).status;
      if (!status.empty()) ++devices[{island_of(tuple), std::string(parts[1]), status}];
    } else if (is(4, 1, "property") && parts[3] == "value") {
      add_property(parts[2], {{"island", island_of(tuple)}}, tuple.value, text);
    } else if (is(5, 2, "property") && parts[4] == "value") {
      add_property(parts[3], {{"island", island_of(tuple)}, {"network", std::string(parts[1])}}, tuple.value, text);
    }
  }
  for (const auto& [place, count] : devices)
    text.add("rubicon_devices", "gauge", {{"island", place[0]}, {"network", place[1]}, {"status", place[2]}},
             std::to_string(count));
}

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

void add_history(const history::HistoryCounters& counters, MetricsText& text) {
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
