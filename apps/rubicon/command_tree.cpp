#include <fmt/format.h>

#include <map>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/device_options.h"
#include "apps/rubicon/tuple_text.h"

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
    out += fmt::format("{}{}{}{}{}\n", margin, last ? "└─ " : "├─ ", clean(name), child.about.empty() ? "" : "  ",
                       clean(child.about));
    draw(child, margin + (last ? "   " : "│  "), out);
  }
}

Line json_of(const Node& node) {
  Line line = Line::object();
  for (const auto& [name, child] : node.below) line[name] = child.below.empty() ? Line(child.about) : json_of(child);
  return line;
}

/// Values, units and qualities of points, by owner and key of the point.
class Points {
 public:
  explicit Points(const std::vector<client::Tuple>& tuples) : states_(states_of(tuples)) {
    for (const auto& tuple : tuples) {
      const auto last = last_part(tuple.key);
      const std::pair name(tuple.owner, without_last_part(tuple.key));
      if (last == "value") values_[name] = tuple.value;
      if (last == "description") units_[name] = text_in(object_of(tuple.value), "unit");
    }
  }
  std::string text(OwnerId owner, const std::string& key, WallTime now) const {
    const std::pair name(owner, key);
    const auto value = values_.find(name);
    const auto unit = units_.find(name);
    const auto state = states_.find(name);
    std::string text = value == values_.end() || value->second.empty() ? "-" : value->second;
    if (unit != units_.end() && !unit->second.empty() && unit->second != "1") text += " " + unit->second;
    if (state != states_.end())
      text += fmt::format("  {} {}", state->second.quality, age_text(state->second.heard, now));
    return text;
  }

 private:
  std::map<std::pair<OwnerId, std::string>, std::string> values_, units_;
  PointStates states_;
};

void add_points(Node& node, const client::Device& device, const Points& points, WallTime now) {
  const auto add = [&](const char* kind, const std::vector<std::string>& ids) {
    for (const auto& id : ids)
      node.below[id].about = points.text(device.island, fmt::format("{}.{}.{}", device.key(), kind, id), now);
  };
  add("sensor", device.sensors);
  add("actuator", device.actuators);
  add("property", device.properties);
}

int tree(Session& session, const DeviceOptions& options) {
  session.meet();
  const auto query = options.query();
  const auto devices = session.client().devices(query, session.settings().patience);
  if (devices.empty()) return session.nothing("no such device");
  std::vector<client::Tuple> tuples;
  for (const auto* last : {"value", "status", "description"}) {
    for (auto& tuple : session.read({query.island, fmt::format("*.*.*.*.*.{}", last)}))
      tuples.push_back(std::move(tuple));
  }
  const Points points(tuples);
  std::map<OwnerId, Node> islands;
  for (const auto& island : session.client().islands()) {
    if (!query.island || *query.island == island.id) islands[island.id].about = island.summary.name;
  }
  for (const auto& device : devices) {
    auto& node = islands[device.island].below[device.network].below[device.id];
    node.about = device.name + (device.name.empty() ? "" : "  ") + device.status;
    add_points(node, device, points, session.now());
  }
  for (const auto& [id, node] : islands) {
    if (session.json()) {
      session.out().line(dump({{"island", number(id)}, {"name", node.about}, {"networks", json_of(node)}}));
      continue;
    }
    std::string text = bold(fmt::format("{} {}", number(id), clean(node.about)), session.look().colour) + "\n";
    draw(node, "", text);
    session.out().write(text);
  }
  return kGood;
}

}  // namespace

void add_tree(Cli& cli) {
  const auto options = std::make_shared<DeviceOptions>();
  auto* app = cli.command_in_ecology({"tree", "Show islands, their networks, devices and points as a tree",
                                      "  rubicon tree\n"
                                      "  rubicon tree --island 6541 --network 'dummy*'\n"},
                                     [options](Session& session) { return tree(session, *options); });
  options->add_to(*app);
}

}  // namespace rubicon::cli
