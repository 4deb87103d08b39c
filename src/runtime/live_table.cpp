#include "runtime/live_table.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "model/key.h"

namespace rubicon::runtime {

namespace {

using nlohmann::json;

json parsed(const std::string& text) {
  auto tree = json::parse(text, nullptr, false);
  return tree.is_object() ? tree : json::object();
}

std::string age_text(double seconds) {
  if (seconds < 0) return "-";
  if (seconds < 10) return fmt::format("{:.1f}s", seconds);
  if (seconds < 120) return fmt::format("{:.0f}s", seconds);
  if (seconds < 7200) return fmt::format("{:.0f}min", seconds / 60);
  return fmt::format("{:.0f}h", seconds / 3600);
}

/// Cut to the width in characters of UTF-8, padded with blanks.
std::string fitted(std::string_view text, std::size_t width) {
  std::string out;
  std::size_t shown = 0;
  for (const char c : text) {
    const bool follows = (static_cast<unsigned char>(c) & 0xc0U) == 0x80;
    if (!follows && shown == width) break;
    if (!follows) ++shown;
    out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  }
  return out + std::string(width - shown, ' ');
}

std::string part_of(std::string_view key, std::size_t index) {
  const auto parts = model::key_parts(key);
  return index < parts.size() ? std::string(parts[index]) : std::string();
}

}  // namespace

LiveTable::LiveTable(const TupleSpace& space, OwnerId island, std::string name, std::string prefix)
    : space_(space), island_(island), name_(std::move(name)), prefix_(std::move(prefix)) {}

std::string LiveTable::value(const std::string& key) const {
  const auto tuple = space_.get(island_, key);
  return tuple ? std::string(tuple->value) : std::string();
}

std::string LiveTable::top_line(WallTime now) const {
  std::size_t devices = 0;
  std::size_t reachable = 0;
  space_.list({island_, prefix_ + ".*.*.status"}, [&](const tuples::TupleView& tuple) {
    ++devices;
    if (tuple.value.find("\"reachable\"") != tuple.value.npos) ++reachable;
  });
  return fmt::format("Rubicon island {} {}   {} of {} devices reachable   {:%H:%M:%S} UTC", number(island_), name_,
                     reachable, devices, std::chrono::floor<std::chrono::seconds>(now));
}

void LiveTable::network_rows(std::vector<Row>& rows) const {
  rows.push_back({fmt::format("{:<20}{:<12}{}", "NETWORK", "LINE", "WHY"), true});
  space_.list({island_, prefix_ + ".*.status"}, [&](const tuples::TupleView& tuple) {
    const auto status = parsed(std::string(tuple.value));
    rows.push_back(
        {fmt::format("{:<20}{:<12}{}", part_of(tuple.key, 1), status.value("line", ""), status.value("reason", "")),
         false});
  });
}

void LiveTable::point_rows(const std::string& device, std::vector<Row>& rows, WallTime now) const {
  const auto add = [&](const tuples::TupleView& tuple) {
    const auto point = std::string(tuple.key.substr(0, tuple.key.rfind('.')));
    const auto status = parsed(value(point + ".status"));
    const auto about = parsed(value(point + ".description"));
    auto unit = about.value("unit", "1");
    if (unit == "1") unit.clear();
    const auto heard = status.value("heard", 0.0);
    const auto command = status.contains("command") ? status["command"].value("state", "") : std::string();
    rows.push_back({fmt::format("    {}  {} {} {:<14} {:>7}  {}", fitted(part_of(tuple.key, 4), 28),
                                fitted(tuple.value, 14), fitted(unit, 8), status.value("quality", ""),
                                age_text(heard > 0 ? base::to_seconds(now) - heard : -1), command),
                    false});
  };
  space_.list({island_, device + ".sensor.*.value"}, add);
  space_.list({island_, device + ".actuator.*.value"}, add);
}

void LiveTable::device_rows(std::vector<Row>& rows, WallTime now) const {
  std::set<std::string> devices;
  space_.list({island_, prefix_ + ".*.*.status"},
              [&](const tuples::TupleView& tuple) { devices.emplace(tuple.key.substr(0, tuple.key.rfind('.'))); });
  rows.push_back({fmt::format("{:<34}{:<15} {:<8} {:<14} {:>7}  {}", "DEVICE", "VALUE", "UNIT", "QUALITY", "HEARD",
                              "LAST COMMAND"),
                  true});
  for (const auto& device : devices) {
    const auto about = parsed(value(device + ".description"));
    const auto status = parsed(value(device + ".status"));
    rows.push_back({fmt::format("  {}  {}  {}", device, about.value("name", ""), status.value("status", "")), false});
    point_rows(device, rows, now);
  }
}

std::string LiveTable::command_to_try() const {
  std::string key;
  std::string to;
  space_.list({island_, prefix_ + ".*.*.actuator.*.command"}, [&](const tuples::TupleView& tuple) {
    const auto point = std::string(tuple.key.substr(0, tuple.key.rfind('.')));
    const auto about = parsed(value(point + ".description"));
    if (about.value("data_type", "") != "boolean" || (!key.empty() && tuple.key > key)) return;
    key = tuple.key;
    const auto words = about.value("words", json::array({"off", "on"}));
    const auto now = value(point + ".value");
    to = words.size() == 2 && words[1] != now ? words[1] : words.at(0);
  });
  return key.empty() ? std::string("help, devices, ls **, quit") : fmt::format("set {} {}", key, to);
}

std::string LiveTable::render(WallTime now, ScreenSize size) const {
  std::vector<Row> rows{{top_line(now), true}, {}};
  network_rows(rows);
  rows.push_back({});
  device_rows(rows, now);
  const auto room = static_cast<std::size_t>(std::max(size.rows, 4)) - 2;
  if (rows.size() > room) {
    const auto hidden = rows.size() - room + 1;
    rows.resize(room - 1);
    rows.push_back({fmt::format("  ... {} more lines; enlarge the terminal, or use --watch and --shell", hidden)});
  }
  const auto width = static_cast<std::size_t>(std::max(size.columns, 20));
  std::string screen;
  for (const auto& row : rows) {
    const auto text = fitted(row.text, width);
    screen += row.heading ? fmt::format("\x1b[1m{}\x1b[0m\n", text) : text + "\n";
  }
  return screen + fitted(" try: " + command_to_try(), width);
}

}  // namespace rubicon::runtime
