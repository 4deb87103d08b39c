#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <utility>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/targets/options.h"
#include "apps/rubicon/targets/suggestions.h"
#include "base/compare_text.h"
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
  if (near.empty() && !query.name.empty()) near = suggest_device({all, {}}, query.name);
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

/// What a device is, and the state of the device and of its line: one line each.
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

/// A device, and which of its points are shown.
struct Described {
  Device device;
  std::vector<client::Place> places;
  client::KnownNames names;

  model::PointKey key(const client::Place& place) const {
    return model::DeviceKey{device.key()}.point(place.kind, place.id);
  }
  std::string name(const client::Place& place) const {
    return client::name_of_point(names, device.island, key(place).text);
  }
};

void describe_for_people(Session& session, const Described& what, const Tree& tree) {
  const auto& device = what.device;
  write_head(session, device);
  std::vector<client::Tuple> tuples;
  for (const auto& entry : tree) tuples.push_back(entry.second);
  std::map<std::string, client::Point> points;
  for (auto& point : client::points_from(tuples)) points.emplace(point.key(), std::move(point));
  const bool has_names =
      std::any_of(what.places.begin(), what.places.end(), [&](const auto& place) { return !what.name(place).empty(); });
  Table table({{"KIND", Column::Kind::kWord, 4},
               {"POINT", Column::Kind::kKey},
               {has_names ? "NAME" : "", Column::Kind::kText, 5},
               {"VALUE", Column::Kind::kValue},
               {"UNIT"},
               {"QUALITY"},
               {"HEARD", Column::Kind::kWord, 3},
               {"RANGE", Column::Kind::kText, 2},
               {"LAST COMMAND", Column::Kind::kText, 1}});
  std::string reasons;
  for (const auto& place : what.places) {
    const auto key = what.key(place);
    const auto& point = points[key.text];
    const auto about = model::point_description_from_json(value_in(tree, key.description()));
    const auto& status = point.status;
    table.row({std::string(to_string(place.kind)), place.id, what.name(place), point.value(),
               model::unit_text(point.unit), status.quality, age_text(status.heard, session.now()),
               about ? range_text(*about) : "", status.command});
    const bool is_told = status.reason.empty() || status.reason == device.reason || status.reason == device.line.reason;
    if (!is_told) reasons += fmt::format("{} is {}\n", printable(place.id), printable(quality_text(point)));
  }
  if (table.empty()) return;
  session.out().write("\n" + table.text(session.look()) + (reasons.empty() ? "" : "\n" + reasons));
}

void describe_for_programs(Session& session, const Described& what, const Tree& tree) {
  auto line = client::device_json(what.device);
  line["points"] = Line::array();
  for (const auto& place : what.places) {
    auto point = client::place_json(what.device, place, texts_in(tree, what.key(place)));
    if (const auto name = what.name(place); !name.empty()) point["name"] = name;
    line["points"].push_back(std::move(point));
  }
  session.out().line(model::dump(line));
}

struct DescribeOptions {
  IslandOption island;
  std::string device;
};

/// The device that has all these points, with only them; false: they are of several devices, or there are none.
bool describes_points(const std::vector<Pattern>& points, Described& what) {
  for (const auto& device : what.names.devices) {
    std::vector<client::Place> places;
    for (const auto& place : client::places_of(device)) {
      const auto key = model::DeviceKey{device.key()}.point(place.kind, place.id).text;
      const auto fits = [&](const Pattern& one) { return one.matches(device.island, key); };
      if (std::any_of(points.begin(), points.end(), fits)) places.push_back(place);
    }
    if (places.empty() || places.size() != points.size()) continue;
    what.device = device;
    what.places = std::move(places);
    return true;
  }
  return false;
}

int describe(Session& session, DescribeOptions options) {
  if (const int code = options.island.put_before(session, options.device); code != kGood) return code;
  Described what;
  what.names = known_names(session);
  const bool is_device = !client::devices_called(what.names, options.device).empty();
  const auto points = client::points_called(what.names, options.device, client::Among::kAll);
  if (is_device || !describes_points(points, what)) {
    if (const int code = one_device(session, what.names, options.device, what.device); code != kGood) return code;
    what.places = client::places_of(what.device);
  }
  const auto& device = what.device;
  Tree tree;
  for (auto& tuple : session.read({device.island, device.key() + ".**"})) tree.emplace(tuple.key, std::move(tuple));
  session.json() ? describe_for_programs(session, what, tree) : describe_for_people(session, what, tree);
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
  const auto options = std::make_shared<DescribeOptions>();
  auto* app = cli.command_in_ecology({"describe", "Show a device: its points with type, unit, value and quality",
                                      "  rubicon describe bedroom\n"
                                      "  rubicon describe 'Living room'\n"
                                      "  rubicon describe 'Reading lamp'              # a point with this name\n"
                                      "  rubicon describe 6541:proxy.dummy-rooms.living\n"},
                                     [options](Session& session) { return describe(session, *options); });
  app->add_option("DEVICE", options->device,
                  "key part, network.device, whole key, name or address; or a point of it: DEVICE.POINT, or its name")
      ->required();
  options->island.add_to(app);
}

namespace {

/// One line of the tree and what is below it, in order of keys.
struct Node {
  std::string about;
  std::map<std::string, Node> below;
};

void draw(const Node& node, const std::string& margin, std::string& out) {
  std::size_t left = node.below.size();
  for (const auto& [name, child] : node.below) {
    const bool last = --left == 0;
    out += fmt::format("{}{}{}{}{}\n", margin, last ? "└─ " : "├─ ", printable(name), child.about.empty() ? "" : "  ",
                       printable(child.about));
    draw(child, margin + (last ? "   " : "│  "), out);
  }
}

Line json_of(const Node& node) {
  Line line = Line::object();
  for (const auto& [name, child] : node.below) line[name] = child.below.empty() ? Line(child.about) : json_of(child);
  return line;
}

/// The text after a point: value with unit, quality, age.
using About = std::map<std::pair<OwnerId, std::string>, std::string>;

About about_points(const std::vector<client::Point>& points, WallTime now) {
  About about;
  for (const auto& point : points) {
    auto text = point.value().empty() ? std::string("-") : point.value();
    if (const auto unit = model::unit_text(point.unit); !unit.empty()) text += " " + unit;
    if (!point.status.quality.empty())
      text += fmt::format("  {} {}", point.status.quality, age_text(point.status.heard, now));
    about[{point.tuple.owner, point.key()}] = std::move(text);
  }
  return about;
}

std::string text_at(const About& about, const std::pair<OwnerId, std::string>& name) {
  const auto found = about.find(name);
  return found == about.end() ? "-" : found->second;
}

void add_points(Node& node, const client::Device& device, const About& about) {
  const auto add = [&](Kind kind, const std::vector<std::string>& ids) {
    for (const auto& id : ids)
      node.below[id].about = text_at(about, {device.island, model::DeviceKey{device.key()}.point(kind, id).text});
  };
  add(Kind::kSensor, device.sensors);
  add(Kind::kActuator, device.actuators);
  add(Kind::kProperty, device.properties);
}

int tree(Session& session, const client::DeviceQuery& query) {
  session.discover();
  const auto devices = session.client().devices(query, session.settings().patience);
  if (devices.empty()) return session.not_found("no such device");
  const auto points =
      session.client().read_points({query.island, model::any_point().text}, session.settings().patience);
  const auto about = points ? about_points(*points, session.now()) : About();
  std::map<OwnerId, Node> islands;
  for (const auto& island : session.client().islands()) {
    if (!query.island || *query.island == island.id) islands[island.id].about = island.summary.name;
  }
  for (const auto& device : devices) {
    auto& network = islands[device.island].below[device.network];
    network.about = "line " + line_text(device.line);
    auto& node = network.below[device.id];
    node.about = device.name + (device.name.empty() ? "" : "  ") + device.status;
    if (!device.reason.empty()) node.about += ": " + device.reason;
    add_points(node, device, about);
  }
  for (const auto& [id, node] : islands) {
    if (session.json()) {
      session.out().line(model::dump({{"island", number(id)}, {"name", node.about}, {"networks", json_of(node)}}));
      continue;
    }
    std::string text = bold(fmt::format("{} {}", number(id), printable(node.about)), session.look().colour) + "\n";
    draw(node, "", text);
    session.out().write(text);
  }
  return kGood;
}

}  // namespace

void add_tree(Cli& cli) {
  const auto options = std::make_shared<DeviceOptions>();
  auto* app =
      cli.command_in_ecology({"tree", "Show islands, their networks, devices and points as a tree",
                              "  rubicon tree\n"
                              "  rubicon tree --island 6541 --network 'dummy*'\n"},
                             [options](Session& session) {
                               return options->run(session, [&](const auto& query) { return tree(session, query); });
                             });
  options->add_to(*app);
}

namespace {

struct RenameOptions {
  IslandOption island{};
  std::string device{}, name{}, area{};
  CLI::Option *name_option = nullptr, *area_option = nullptr;  ///< an empty text is given, too

  bool has_name() const { return name_option->count() > 0; }
  bool has_area() const { return area_option->count() > 0; }
};

int rename(Session& session, RenameOptions options) {
  if (!options.has_name() && !options.has_area()) {
    print_error("rename: expected a NAME, --area AREA, or both");
    return kUsage;
  }
  client::Device device;
  if (const int code = options.island.put_before(session, options.device); code != kGood) return code;
  if (const int code = one_device(session, options.device, device); code != kGood) return code;
  Line given;
  if (options.has_name()) given["name"] = options.name;
  if (options.has_area()) given["area"] = options.area;
  const auto outcome = session.command(device.island, model::DeviceKey{device.key()}.description(), model::dump(given));
  if (session.json()) {
    Line line;
    line["island"] = number(device.island);
    line["key"] = device.key();
    line.update(given);
    line["state"] = outcome.state;
    line["reason"] = outcome.reason;
    session.out().line(model::dump(line));
  } else if (outcome.good()) {
    const auto name = options.has_name() ? options.name : device.name;
    const auto area = options.has_area() ? options.area : device.area;
    session.out().line(fmt::format("{} is {}{}", name_of(device.island, device.key()),
                                   name.empty() ? "without a given name" : model::quoted(name),
                                   area.empty() ? "" : " in " + model::quoted(area)));
  } else {
    print_error(fmt::format("{}: {}", outcome.state, printable(outcome.reason)));
  }
  return exit_code_of(outcome.state);
}

}  // namespace

void add_rename(Cli& cli) {
  const auto options = std::make_shared<RenameOptions>();
  auto* app = cli.command_in_ecology(
      {"rename", "Give a device a name for people and the area where it is",
       "  rubicon rename dummy-rooms.living 'Living lamp' --area 'Living room'\n"
       "  rubicon rename dummy-rooms.living --area Attic\n"
       "  rubicon rename dummy-rooms.living '' --area ''        # removes both\n"
       "The island keeps both in its state file; keys stay. What its configuration says goes before.\n"},
      [options](Session& session) { return rename(session, *options); });
  app->add_option("DEVICE", options->device, "key part, network.device, whole key, name or address")->required();
  options->island.add_to(app);
  options->name_option = app->add_option("NAME", options->name, "the new name; '' for the device's own again");
  options->area_option = app->add_option("--area", options->area, "room or place; '' for none");
}

}  // namespace rubicon::cli
