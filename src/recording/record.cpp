#include "recording/record.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/bytes.h"
#include "base/clocks.h"
#include "base/text.h"
#include "model/json_members.h"

namespace rubicon::recording {

std::string_view to_string(RecordKind kind) {
  switch (kind) {
    case RecordKind::kSet: return "set";
    case RecordKind::kDeleted: return "deleted";
    case RecordKind::kExpired: return "expired";
    case RecordKind::kPresent: return "present";
    case RecordKind::kMark: return "mark";
  }
  return "unknown";
}

namespace {

/// Exact, negative times too.
std::string seconds(WallTime time) {
  const auto micros = time.time_since_epoch().count();
  const auto rest = micros % 1'000'000;
  const bool negative = micros < 0;
  return fmt::format("{}{}.{:06}", negative ? "-" : "", negative ? -(micros / 1'000'000) : micros / 1'000'000,
                     negative ? -rest : rest);
}

std::string seconds_or_nothing(WallTime time) {
  return time == WallTime{} ? std::string() : seconds(time);
}

}  // namespace

void append_csv_cell(std::string_view text, std::string& out) {
  const bool blanks = !text.empty() && (text.front() == ' ' || text.back() == ' ');
  if (!blanks && text.find_first_of(",\"\r\n") == text.npos) {
    out += text;
    return;
  }
  out += '"';
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  out += '"';
}

void append_csv_line(const recording::Record& record, std::string& out) {
  const bool text = base::is_utf8(record.value);
  base::append(out, "{},{},{},", seconds(record.seen), to_string(record.kind), number(record.owner));
  append_csv_cell(record.key, out);
  out += ',';
  if (text) {
    append_csv_cell(record.value, out);
  } else {
    out += base::to_hex(base::as_bytes(record.value));
  }
  out += text ? ",text," : ",hex,";
  append_csv_cell(record.media_type, out);
  base::append(out, ",{},{},{},{},{}\n", number(record.creator), record.sequence, seconds_or_nothing(record.write_time),
               seconds_or_nothing(record.user_time), seconds_or_nothing(record.expire_time));
}

void append_json_line(const recording::Record& record, std::string& out) {
  nlohmann::ordered_json line;
  line["seen"] = base::to_seconds(record.seen);
  line["event"] = to_string(record.kind);
  line["owner"] = number(record.owner);
  line["key"] = record.key;
  if (base::is_utf8(record.value)) {
    line["value"] = record.value;
  } else {
    line["value_hex"] = base::to_hex(base::as_bytes(record.value));
  }
  line["mimetype"] = record.media_type;
  line["creator"] = number(record.creator);
  line["seq"] = record.sequence;
  line["write"] = base::to_seconds(record.write_time);
  line["user"] = base::to_seconds(record.user_time);
  line["expire"] = base::to_seconds(record.expire_time);
  out += model::dump(line);
  out += '\n';
}

std::string utc_text(WallTime time) {
  constexpr std::int64_t kLast = 253'402'300'799;  // year 9999
  const auto whole = std::chrono::floor<std::chrono::seconds>(time);
  const auto count = whole.time_since_epoch().count();
  if (count < 0 || count > kLast) return seconds(time) + " s since 1970";
  return fmt::format("{}.{:06} UTC", base::utc_text(time, "%Y-%m-%d %H:%M:%S"), (time - whole).count());
}

}  // namespace rubicon::recording
