#include "web/api/metrics_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "base/text.h"
#include "model/point_keys.h"
#include "model/point_tuples.h"

namespace rubicon::web::api {

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

}  // namespace rubicon::web::api
