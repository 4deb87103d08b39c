#include <fmt/format.h>

#include <map>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/device_options.h"
#include "apps/rubicon/tuple_text.h"
#include "model/json_members.h"
#include "model/point_keys.h"
#include "rubicon/unit.hpp"

namespace rubicon::cli {

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

}  // namespace rubicon::cli
