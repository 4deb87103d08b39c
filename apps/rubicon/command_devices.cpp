#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/device_options.h"
#include "apps/rubicon/tuple_text.h"

namespace rubicon::cli {

namespace {

using client::Device;

Line device_json(const Device& device) {
  Line line;
  line["island"] = number(device.island);
  line["key"] = device.key();
  line["network"] = device.network;
  line["id"] = device.id;
  line["name"] = device.name;
  line["model"] = device.model;
  line["type"] = device.type;
  line["address"] = device.address;
  line["status"] = device.status;
  line["sensors"] = device.sensors;
  line["actuators"] = device.actuators;
  line["properties"] = device.properties;
  return line;
}

int list(Session& session, const DeviceOptions& options) {
  session.meet();
  const auto query = options.query();
  const auto found = session.client().devices(query, session.settings().patience);
  if (found.empty()) return session.nothing("no such device");
  Table table({"DEVICE", "NAME", "STATUS", "TYPE", "SENSORS", "ACTUATORS"});
  for (const auto& device : found) {
    if (session.json()) session.out().line(dump(device_json(device)));
    table.row({name_of(device.island, device.key()), device.name, device.status,
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

std::string range_of(const nlohmann::json& about) {
  const auto words = about.find("words");
  if (words != about.end() && words->is_array() && !words->empty()) {
    std::string all;
    for (const auto& word : *words) {
      if (word.is_string()) all += (all.empty() ? "" : "|") + word.get<std::string>();
    }
    return all;
  }
  const auto number_text = [&about](const char* name) {
    const auto found = about.find(name);
    return found != about.end() && found->is_number() ? fmt::format("{:g}", found->get<double>()) : std::string();
  };
  const auto low = number_text("minimum"), high = number_text("maximum");
  return low.empty() && high.empty() ? "" : low + ".." + high;
}

struct Point {
  const char* kind;
  std::string id;
};

std::vector<Point> points_of(const Device& device) {
  std::vector<Point> points;
  for (const auto& id : device.sensors) points.push_back({"sensor", id});
  for (const auto& id : device.actuators) points.push_back({"actuator", id});
  for (const auto& id : device.properties) points.push_back({"property", id});
  return points;
}

Line point_json(const Tree& tree, const std::string& key, const Point& point) {
  Line line;
  line["kind"] = point.kind;
  line["id"] = point.id;
  line["key"] = key;
  line["value"] = value_in(tree, key + ".value");
  line["status"] = object_of(value_in(tree, key + ".status"));
  line["description"] = object_of(value_in(tree, key + ".description"));
  return line;
}

void describe_for_people(Session& session, const Device& device, const Tree& tree) {
  const auto look = session.look();
  auto& out = session.out();
  const auto status = object_of(value_in(tree, device.key() + ".status"));
  const auto put = [&](const char* name, const std::string& text) {
    if (!text.empty()) out.line(fmt::format("{} {}", bold(fmt::format("{:<8}", name), look.colour), clean(text)));
  };
  put("device", name_of(device.island, device.key()));
  put("name", device.name);
  put("model", device.model);
  put("type", device.type);
  put("address", device.address);
  const auto since = wall_time(number_in(status, "since"));
  const auto reason = text_in(status, "reason");
  put("status",
      fmt::format("{} for {}{}", device.status, age_text(since, session.now()), reason.empty() ? "" : ": " + reason));
  Table table({"KIND", "POINT", "VALUE", "UNIT", "QUALITY", "HEARD", "RANGE", "LAST COMMAND"});
  for (const auto& point : points_of(device)) {
    const auto key = fmt::format("{}.{}.{}", device.key(), point.kind, point.id);
    const auto state = point_state(value_in(tree, key + ".status"));
    const auto about = object_of(value_in(tree, key + ".description"));
    const auto unit = text_in(about, "unit");
    table.row({point.kind, point.id, value_in(tree, key + ".value"), unit == "1" ? "" : unit, state.quality,
               age_text(state.heard, session.now()), range_of(about), state.command});
  }
  if (!table.empty()) out.write("\n" + table.text(look));
}

void describe_for_programs(Session& session, const Device& device, const Tree& tree) {
  auto line = device_json(device);
  line["points"] = Line::array();
  for (const auto& point : points_of(device))
    line["points"].push_back(point_json(tree, fmt::format("{}.{}.{}", device.key(), point.kind, point.id), point));
  session.out().line(dump(line));
}

int describe(Session& session, const std::string& word) {
  session.meet();
  const auto found = devices_called(session.client().devices({}, session.settings().patience), word);
  if (found.empty()) return session.nothing(fmt::format("no device {}", model::quoted(word)));
  if (found.size() > 1) {
    std::string names;
    for (const auto& device : found) names += "\n  " + name_of(device.island, device.key());
    say(fmt::format("{} may be each of these devices, say which:{}", model::quoted(word), names));
    return kUsage;
  }
  const auto& device = found[0];
  Tree tree;
  for (auto& tuple : session.read({device.island, device.key() + ".**"})) tree.emplace(tuple.key, std::move(tuple));
  session.json() ? describe_for_programs(session, device, tree) : describe_for_people(session, device, tree);
  return kGood;
}

}  // namespace

void add_devices(Cli& cli) {
  const auto options = std::make_shared<DeviceOptions>();
  auto* app = cli.command_in_ecology({"devices", "List the devices of all islands",
                                      "  rubicon devices\n"
                                      "  rubicon devices --type temperature --network 'knx*'\n"
                                      "  rubicon devices --island 6541 --json\n"},
                                     [options](Session& session) { return list(session, *options); });
  options->add_to(*app);
}

void add_describe(Cli& cli) {
  const auto device = std::make_shared<std::string>();
  auto* app = cli.command_in_ecology({"describe", "Show a device: its points with type, unit, value and quality",
                                      "  rubicon describe living\n"
                                      "  rubicon describe 'Living room'\n"
                                      "  rubicon describe 6541:proxy.dummy-rooms.living\n"},
                                     [device](Session& session) { return describe(session, *device); });
  app->add_option("DEVICE", *device, "key part, network.device, whole key, name or address")->required();
}

}  // namespace rubicon::cli
