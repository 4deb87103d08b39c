#include "history/history_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/text.h"
#include "model/json_members.h"
#include "recording/record.h"
#include "rubicon/key.hpp"

namespace rubicon::history {

namespace {

using model::append_json;
using model::append_seconds;

void append_number(double value, std::string& out) {
  if (std::isfinite(value)) {
    base::append(out, "{}", value);
  } else {
    out += "null";
  }
}

/// `"name":[...]` with a comma in front.
template <class List, class Put>
void append_list(std::string_view name, const List& list, std::string& out, Put put) {
  base::append(out, ",\"{}\":[", name);
  bool first = true;
  for (const auto& item : list) {
    if (!std::exchange(first, false)) out += ',';
    put(item);
  }
  out += ']';
}

void append_buckets(const SeriesAnswer& series, std::string& out) {
  const auto& all = series.buckets;
  append_list("t", all, out, [&](const Bucket& one) { append_seconds(one.time, out); });
  const bool single = std::all_of(all.begin(), all.end(), [](const Bucket& one) { return one.count == 1; });
  if (single) return append_list("v", all, out, [&](const Bucket& one) { append_number(one.last, out); });
  append_list("first", all, out, [&](const Bucket& one) { append_number(one.first, out); });
  append_list("min", all, out, [&](const Bucket& one) { append_number(one.minimum, out); });
  append_list("max", all, out, [&](const Bucket& one) { append_number(one.maximum, out); });
  append_list("mean", all, out, [&](const Bucket& one) { append_number(one.mean, out); });
  append_list("last", all, out, [&](const Bucket& one) { append_number(one.last, out); });
  append_list("n", all, out, [&](const Bucket& one) { base::append(out, "{}", one.count); });
}

void append_words(const std::vector<std::string>& words, std::string& out) {
  if (!words.empty()) append_list("words", words, out, [&](const std::string& word) { append_json(word, out); });
}

void append_head(const SeriesName& name, SeriesKind kind, const std::string& unit, std::string& out) {
  out += "{\"key\":";
  append_json(to_string(name), out);
  base::append(out, ",\"kind\":\"{}\",\"unit\":", to_string(kind));
  append_json(unit, out);
}

void append_series(const SeriesAnswer& series, std::string& out) {
  append_head(series.name, series.kind, series.unit, out);
  append_words(series.words, out);
  if (series.before) {
    out += ",\"before\":[";
    append_seconds(series.before->time, out);
    out += ',';
    append_number(series.before->value, out);
    out += ']';
  }
  const auto append_text = [&](const TextValue& text) {
    out += '[';
    append_seconds(text.time, out);
    out += ',';
    append_json(text.text, out);
    out += ']';
  };
  if (series.text_before) {
    out += ",\"before\":";
    append_text(*series.text_before);
  }
  if (series.kind == SeriesKind::kText) {
    append_list("texts", series.texts, out, append_text);
  } else {
    append_buckets(series, out);
  }
  append_list("gaps", series.gaps, out, [&](const Gap& gap) {
    out += '[';
    append_seconds(gap.from, out);
    out += ',';
    append_seconds(gap.to, out);
    out += ']';
  });
  out += '}';
}

/// The word for a number; empty if there is none, as in a damaged file.
std::string word_of(const std::vector<std::string>& words, double value) {
  const bool stands = value >= 0 && value < static_cast<double>(words.size());
  return stands ? words[static_cast<std::size_t>(value)] : std::string();
}

void append_cells(const SeriesAnswer& series, const Bucket& bucket, std::string& out) {
  append_seconds(bucket.time, out);
  base::append(out, ",{},{},", to_string(series.name), bucket.count);
  if (series.kind == SeriesKind::kWords) {
    recording::append_csv_cell(word_of(series.words, bucket.first), out);
    out += ",,,,";
    recording::append_csv_cell(word_of(series.words, bucket.last), out);
  } else {
    base::append(out, "{},{},{},{},{}", bucket.first, bucket.minimum, bucket.maximum, bucket.mean, bucket.last);
  }
  out += '\n';
}

}  // namespace

std::string_view to_string(SeriesKind kind) {
  switch (kind) {
    case SeriesKind::kNumber: return "number";
    case SeriesKind::kWords: return "words";
    case SeriesKind::kText: return "text";
  }
  return "number";
}

std::string to_string(const SeriesName& name) {
  return fmt::format("{}:{}", number(name.owner), name.key);
}

Result<SeriesName> parse_series(std::string_view text) {
  auto pattern = Pattern::parse(text);
  if (!pattern) return fail(pattern.error());
  if (pattern->owner && pattern->exact()) return SeriesName{*pattern->owner, std::move(pattern->key)};
  return fail(
      ErrorCode::kInvalid,
      fmt::format("{} is not a series, expected an owner and a key, as in 6541:proxy.wsn-1.7.sensor.light-1.value",
                  model::quoted(text)));
}

std::string to_json(const Answer& answer) {
  std::string out = "{\"from\":";
  append_seconds(answer.from, out);
  out += ",\"to\":";
  append_seconds(answer.to, out);
  base::append(out, ",\"bucket\":{}", std::chrono::duration<double>(answer.bucket).count());
  append_list("series", answer.series, out, [&](const SeriesAnswer& series) { append_series(series, out); });
  return out + '}';
}

std::string to_json(const std::vector<SeriesEntry>& series) {
  std::string out = "{\"series\":[";
  bool first = true;
  for (const auto& one : series) {
    if (!std::exchange(first, false)) out += ',';
    append_head(one.name, one.kind, one.unit, out);
    append_words(one.words, out);
    out += ",\"first\":";
    append_seconds(one.first, out);
    out += ",\"last\":";
    append_seconds(one.last, out);
    out += '}';
  }
  return out + "]}";
}

std::string to_csv(const Answer& answer) {
  std::string out = "time,key,count,first,minimum,maximum,mean,last\n";
  for (const auto& series : answer.series) {
    for (const auto& bucket : series.buckets) append_cells(series, bucket, out);
    for (const auto& text : series.texts) {
      append_seconds(text.time, out);
      base::append(out, ",{},1,,,,,", to_string(series.name));
      recording::append_csv_cell(text.text, out);
      out += '\n';
    }
  }
  return out;
}

void append_point_line(const SeriesName& name, WallTime time, std::string_view value, std::string& out) {
  append_seconds(time, out);
  base::append(out, ",{},{},", number(name.owner), name.key);
  recording::append_csv_cell(value, out);
  out += '\n';
}

std::string value_text(const SeriesEntry& series, const Point& point) {
  if (point.gap()) return {};
  return series.kind == SeriesKind::kWords ? word_of(series.words, point.value) : fmt::format("{}", point.value);
}

}  // namespace rubicon::history
