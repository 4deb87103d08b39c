#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <utility>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/device_options.h"
#include "apps/rubicon/suggestions.h"
#include "apps/rubicon/tuple_text.h"
#include "apps/rubicon/type_text.h"
#include "base/nearest.h"
#include "client/json_forms.h"
#include "model/json_members.h"
#include "model/point_keys.h"
#include "model/point_tuples.h"
#include "rubicon/unit.hpp"

namespace rubicon::cli {

namespace {

using client::Device;

/// `unreachable: silent for 60s`; where the line does not work, that.
std::string condition_of(const Device& device) {
  const auto& reason = device.line.works() || device.line.line.empty() || device.status == "reachable"
                           ? device.reason
                           : fmt::format("line {}", line_text(device.line));
  return reason.empty() ? device.status : fmt::format("{}: {}", device.status, reason);
}

/// What the words of a query that found nothing may have been meant for.
std::string suggest_query(Session& session, const client::DeviceQuery& query) {
  const auto all = session.client().devices({}, session.settings().patience);
  auto near = query.type.empty() ? std::string() : suggest_type(all, query.type);
  if (near.empty() && !query.name.empty()) near = suggest_device(all, query.name);
  std::vector<std::string> networks, areas;
  for (const auto& device : all) {
    networks.push_back(device.network);
    areas.push_back(device.area);
  }
  if (near.empty()) near = base::did_you_mean(query.network, networks);
  if (near.empty()) near = base::did_you_mean(query.area, areas);
  return near;
}

int list(Session& session, const client::DeviceQuery& query) {
  session.discover();
  const auto found = session.client().devices(query, session.settings().patience);
  if (found.empty()) return session.not_found("no such device", suggest_query(session, query));
  Table table({{"DEVICE", Column::Kind::kKey},
               {"NAME", Column::Kind::kText, 2},
               {"STATUS", Column::Kind::kText},
               {"TYPE", Column::Kind::kText, 3},
               {"SENSORS", Column::Kind::kText, 1},
               {"ACTUATORS", Column::Kind::kText, 1}});
  for (const auto& device : found) {
    if (session.json()) session.out().line(model::dump(client::device_json(device)));
    table.row({name_of(device.island, device.key()), device.name, condition_of(device),
               device.type.empty() ? device.model : device.type, fmt::format("{}", fmt::join(device.sensors, " ")),
               fmt::format("{}", fmt::join(device.actuators, " "))});
  }
  if (!session.json()) session.out().write(table.text(session.look()));
  return kGood;
}

/// Everything below a device, by key.
using Tree = std::map<std::string, client::Tuple>;

std::string value_in(const Tree& tree, const std::string& key) {
  const auto found = tree.find(key);
  return found == tree.end() ? std::string() : found->second.value;
}

client::PlaceTexts texts_in(const Tree& tree, const model::PointKey& key) {
  return {value_in(tree, key.value()), value_in(tree, key.status()), value_in(tree, key.description())};
}

std::string since_text(const std::string& word, WallTime since, const std::string& reason, WallTime now) {
  return fmt::format("{} for {}{}", word, age_text(since, now), reason.empty() ? "" : ": " + reason);
}

/// What a device is and how it and its line are, a line each.
void write_head(Session& session, const Device& device) {
  const auto look = session.look();
  constexpr std::size_t kName = 9;
  const auto put = [&](const char* name, const std::string& text) {
    if (text.empty()) return;
    const auto room = look.width > 2 * kName ? look.width - kName : 0;
    auto before = bold(fmt::format("{:<{}}", name, kName), look.colour);
    for (const auto& line : wrapped(printable(text), room))
      session.out().line(std::exchange(before, std::string(kName, ' ')) + line);
  };
  put("device", name_of(device.island, device.key()));
  put("name", device.name);
  put("area", device.area);
  put("model", device.model);
  put("type", device.type);
  put("address", device.address);
  put("status", since_text(device.status, device.since, device.reason, session.now()));
  const auto& line = device.line;
  if (line.line.empty()) return;
  const auto next = next_attempt_text(line, session.now());
  put("line", since_text(line.line, line.since, line.reason, session.now()) + (next.empty() ? "" : "; " + next));
}

void describe_for_people(Session& session, const Device& device, const Tree& tree) {
  write_head(session, device);
  std::vector<client::Tuple> tuples;
  for (const auto& entry : tree) tuples.push_back(entry.second);
  std::map<std::string, client::Point> points;
  for (auto& point : client::points_from(tuples)) points.emplace(point.key(), std::move(point));
  Table table({{"KIND", Column::Kind::kWord, 4},
               {"POINT", Column::Kind::kKey},
               {"VALUE", Column::Kind::kValue},
               {"UNIT"},
               {"QUALITY"},
               {"HEARD", Column::Kind::kWord, 3},
               {"RANGE", Column::Kind::kText, 2},
               {"LAST COMMAND", Column::Kind::kText, 1}});
  std::string reasons;
  for (const auto& place : client::places_of(device)) {
    const auto key = model::DeviceKey{device.key()}.point(place.kind, place.id);
    const auto& point = points[key.text];
    const auto about = model::point_description_from_json(value_in(tree, key.description()));
    const auto& status = point.status;
    table.row({std::string(to_string(place.kind)), place.id, point.value(), model::unit_text(point.unit),
               status.quality, age_text(status.heard, session.now()), about ? range_text(*about) : "", status.command});
    const bool is_told = status.reason.empty() || status.reason == device.reason || status.reason == device.line.reason;
    if (!is_told) reasons += fmt::format("{} is {}\n", printable(place.id), printable(quality_text(point)));
  }
  if (table.empty()) return;
  session.out().write("\n" + table.text(session.look()) + (reasons.empty() ? "" : "\n" + reasons));
}

void describe_for_programs(Session& session, const Device& device, const Tree& tree) {
  auto line = client::device_json(device);
  line["points"] = Line::array();
  for (const auto& place : client::places_of(device)) {
    const auto key = model::DeviceKey{device.key()}.point(place.kind, place.id);
    line["points"].push_back(client::place_json(device, place, texts_in(tree, key)));
  }
  session.out().line(model::dump(line));
}

int describe(Session& session, const std::string& word) {
  Device device;
  if (const int code = one_device(session, word, device); code != kGood) return code;
  Tree tree;
  for (auto& tuple : session.read({device.island, device.key() + ".**"})) tree.emplace(tuple.key, std::move(tuple));
  session.json() ? describe_for_programs(session, device, tree) : describe_for_people(session, device, tree);
  return kGood;
}

}  // namespace

void add_devices(Cli& cli) {
  const auto options = std::make_shared<DeviceOptions>();
  auto* app =
      cli.command_in_ecology({"devices", "List the devices of all islands",
                              "  rubicon devices\n"
                              "  rubicon devices --type temperature --network 'knx*'\n"
                              "  rubicon devices --island 6541 --json\n"},
                             [options](Session& session) {
                               return options->run(session, [&](const auto& query) { return list(session, query); });
                             });
  options->add_to(*app);
}

void add_describe(Cli& cli) {
  const auto device = std::make_shared<std::string>();
  auto* app = cli.command_in_ecology({"describe", "Show a device: its points with type, unit, value and quality",
                                      "  rubicon describe bedroom\n"
                                      "  rubicon describe 'Living room'\n"
                                      "  rubicon describe 6541:proxy.dummy-rooms.living\n"},
                                     [device](Session& session) { return describe(session, *device); });
  app->add_option("DEVICE", *device, "key part, network.device, whole key, name or address")->required();
}

}  // namespace rubicon::cli
