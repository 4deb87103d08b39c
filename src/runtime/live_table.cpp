#include "runtime/live_table.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "model/key.h"
#include "runtime/event_json.h"

namespace rubicon::runtime {

namespace {

using nlohmann::json;

json parsed(std::string_view text) {
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

std::string part_of(std::string_view key, std::size_t index) {
  const auto parts = model::key_parts(key);
  return index < parts.size() ? std::string(parts[index]) : std::string();
}

/// A member that is text, else nothing.
std::string text_in(const json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

double number_in(const json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_number() ? found->get<double>() : 0;
}

/// Control characters, those beyond ASCII included (U+0080..U+009F steer some terminals too), do not reach a screen.
bool steers(std::string_view character) {
  const auto first = static_cast<unsigned char>(character[0]);
  if (first < 0x20 || first == 0x7f) return true;
  return first == 0xc2 && character.size() > 1 && static_cast<unsigned char>(character[1]) < 0xa0;
}

/// One device of each network in turn, so that a small screen shows something of all.
std::vector<std::string> alternating(const std::vector<std::string>& devices) {
  std::map<std::string, std::size_t> counts;
  std::vector<std::pair<std::size_t, std::string>> ranked;
  ranked.reserve(devices.size());
  for (const auto& device : devices) ranked.emplace_back(counts[part_of(device, 1)]++, device);
  std::sort(ranked.begin(), ranked.end());
  std::vector<std::string> order;
  order.reserve(ranked.size());
  for (auto& [rank, device] : ranked) order.push_back(std::move(device));
  return order;
}

}  // namespace

std::string fitted(std::string_view text, std::size_t width) {
  std::string out;
  std::size_t shown = 0;
  for (; !text.empty() && shown < width; ++shown) {
    std::size_t length = 1;
    while (length < text.size() && (static_cast<unsigned char>(text[length]) & 0xc0U) == 0x80) ++length;
    const auto character = text.substr(0, length);
    if (is_utf8(character) && !steers(character)) {
      out += character;
    } else {
      out += '?';
    }
    text.remove_prefix(length);
  }
  return out + std::string(width - shown, ' ');
}

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
    const auto status = parsed(tuple.value);
    rows.push_back(
        {fitted(part_of(tuple.key, 1), 20) + fitted(text_in(status, "line"), 12) + text_in(status, "reason"), false});
  });
}

void LiveTable::point_rows(const std::string& device, std::vector<Row>& rows, const Page& page) const {
  const auto add = [&](const tuples::TupleView& tuple) {
    const auto point = std::string(tuple.key.substr(0, tuple.key.rfind('.')));
    const auto status = parsed(value(point + ".status"));
    auto unit = text_in(parsed(value(point + ".description")), "unit");
    if (unit == "1") unit.clear();
    const auto heard = number_in(status, "heard");
    const auto command = status.contains("command") ? status["command"] : json::object();
    rows.push_back(
        {fmt::format("    {} {} {} {:<14} {:>6}  {}", fitted(part_of(tuple.key, 4), page.id_width),
                     fitted(tuple.value, 12), fitted(unit, 6), text_in(status, "quality"),
                     age_text(heard > 0 ? base::to_seconds(page.now) - heard : -1), text_in(command, "state")),
         false});
  };
  space_.list({island_, device + ".sensor.*.value"}, add);
  space_.list({island_, device + ".actuator.*.value"}, add);
}

std::size_t LiveTable::device_rows(const std::vector<std::string>& devices, std::vector<Row>& rows,
                                   const Page& page) const {
  std::size_t done = 0;
  for (const auto& device : devices) {
    if (rows.size() > page.room) break;  // an island may have more devices than one can draw twice a second
    const auto about = parsed(value(device + ".description"));
    const auto status = parsed(value(device + ".status"));
    rows.push_back({fmt::format("  {}  {}  {}", device, text_in(about, "name"), text_in(status, "status")), false});
    point_rows(device, rows, page);
    if (rows.size() < page.room) ++done;
  }
  return done;
}

void LiveTable::all_device_rows(std::vector<Row>& rows, const Page& page) const {
  std::vector<std::string> devices;
  space_.list({island_, prefix_ + ".*.*.status"},
              [&](const tuples::TupleView& tuple) { devices.emplace_back(tuple.key.substr(0, tuple.key.rfind('.'))); });
  std::sort(devices.begin(), devices.end());
  rows.push_back({fmt::format("{:<{}} {:<12} {:<6} {:<14} {:>6}  {}", "DEVICE", page.id_width + 4, "VALUE", "UNIT",
                              "QUALITY", "HEARD", "COMMAND"),
                  true});
  const auto above = rows.size();
  device_rows(devices, rows, page);
  if (rows.size() <= page.room) return;
  rows.resize(above);
  const auto shown = device_rows(alternating(devices), rows, page);
  rows.resize(page.room - 1);
  rows.push_back({fmt::format("  ... {} of {} devices do not fit; enlarge the terminal, or use --watch and --shell",
                              devices.size() - shown, devices.size()),
                  false});
}

std::string LiveTable::command_to_try() const {
  std::string first;
  space_.list({island_, prefix_ + ".*.*.actuator.*.command"}, [&](const tuples::TupleView& tuple) {
    if (!first.empty() && tuple.key > first) return;
    const auto point = std::string(tuple.key.substr(0, tuple.key.rfind('.')));
    if (text_in(parsed(value(point + ".description")), "data_type") == "boolean") first = tuple.key;
  });
  if (first.empty()) return "help, devices, quit";
  const auto point = first.substr(0, first.rfind('.'));
  const auto about = parsed(value(point + ".description"));
  std::vector<std::string> words{"off", "on"};
  if (const auto found = about.find("words"); found != about.end() && found->is_array() && found->size() == 2) {
    for (std::size_t i = 0; i < 2; ++i) {
      if ((*found)[i].is_string()) words[i] = (*found)[i].get<std::string>();
    }
  }
  return fmt::format("set {} {}", first, value(point + ".value") == words[1] ? words[0] : words[1]);
}

std::string LiveTable::render(WallTime now, ScreenSize size) const {
  const auto room = static_cast<std::size_t>(std::max(size.rows, 8)) - 2;
  std::vector<Row> rows{{top_line(now), true}, {}};
  network_rows(rows);
  rows.resize(std::min(rows.size(), room - 3));
  rows.push_back({});
  const auto width = static_cast<std::size_t>(std::max(size.columns, 20));
  all_device_rows(rows, {now, room, std::clamp<std::size_t>(width, 70, 86) - 58});
  std::string screen;
  for (const auto& row : rows) {
    const auto text = fitted(row.text, width);
    screen += row.heading ? fmt::format("\x1b[1m{}\x1b[0m\n", text) : text + "\n";
  }
  return screen + fitted(" try: " + command_to_try(), width);
}

}  // namespace rubicon::runtime
