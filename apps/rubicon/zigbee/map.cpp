#include <fmt/format.h>

#include <map>

#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/zigbee/tool.h"
#include "model/json_members.h"

namespace rubicon::cli::zigbee {

namespace {

using nlohmann::json;

/// The whole map, which comes in parts. A refusal has `why`.
json read_map(Tool& tool) {
  json whole{{"ok", true}, {"nodes", json::array()}, {"links", json::array()}};
  std::uint64_t from = 0;
  for (bool more = true; more;) {
    const auto reply = tool.line().reply_to({{"do", "map"}, {"from", from}}, kMapPatience);
    if (!model::flag_of(reply, "ok")) return reply;
    for (const auto* list : {"nodes", "links"}) {
      for (const auto& one : reply.value(list, json::array())) whole[list].push_back(one);
    }
    const auto next = model::count_of(reply, "next");
    more = model::flag_of(reply, "more") && next > from;
    from = next;
  }
  return whole;
}

void print_nodes(Tool& tool, const json& map) {
  using Kind = Column::Kind;
  Table table({{"NAME", Kind::kText},
               {"ADDRESS", Kind::kKey},
               {"ROLE"},
               {"MODEL", Kind::kText, 1},
               {"DID NOT ANSWER", Kind::kText}});
  for (const auto& node : map["nodes"]) {
    std::string failed;
    for (const auto& what : model::texts_of(node, "failed")) failed += (failed.empty() ? "" : ", ") + what;
    table.row({model::text_of(node, "name"), model::text_of(node, "address"), model::text_of(node, "role"),
               model::text_of(node, "model"), failed});
  }
  tool.out().write(table.text(tool.look()));
}

void print_links(Tool& tool, const json& map) {
  std::map<std::string, std::string> names;
  for (const auto& node : map["nodes"]) names[model::text_of(node, "address")] = model::text_of(node, "name");
  const auto name = [&names](const std::string& address) {
    const auto found = names.find(address);
    return found == names.end() ? address : found->second;
  };
  Table table({{"FROM", Column::Kind::kText},
               {"TO", Column::Kind::kText},
               {"LINK QUALITY"},
               {"RELATION", Column::Kind::kText, 1}});
  for (const auto& link : map["links"])
    table.row({name(model::text_of(link, "source")), name(model::text_of(link, "target")),
               fmt::format("{:.0f}", model::number_of(link, "quality")), model::text_of(link, "relation")});
  if (!table.empty()) tool.out().write("\n" + table.text(tool.look()));
}

int show_map(Tool& tool) {
  if (!tool.json() && tool.out().is_terminal()) {
    tool.out().line("Zigbee2MQTT asks every router; this takes up to two minutes");
    tool.out().flush();
  }
  const auto map = read_map(tool);
  if (!model::flag_of(map, "ok")) return refused(map);
  if (tool.json()) {
    tool.print_json(map);
    return kGood;
  }
  print_nodes(tool, map);
  print_links(tool, map);
  return kGood;
}

void print_health(Tool& tool, const json& reply) {
  auto& out = tool.out();
  const auto bridge = reply.value("bridge", json::object());
  const auto health = reply.value("health", json::object());
  out.line(fmt::format("Zigbee2MQTT {} is {}", printable(model::text_of(bridge, "version")),
                       model::flag_of(reply, "healthy") ? "healthy" : "not healthy"));
  out.line(printable(fmt::format("coordinator {}, channel {}{}", model::text_of(bridge, "coordinator"),
                                 model::count_of(bridge, "channel"),
                                 model::flag_of(bridge, "permit_join") ? ", devices may join" : "")));
  if (model::flag_of(bridge, "restart_required")) out.line("it waits for a restart to use changed settings");
  if (!health.contains("uptime_seconds")) return;
  out.line(fmt::format("up for {:.1f} h, {:.0f} MB of memory; MQTT: {} received, {} published, {} queued",
                       model::number_of(health, "uptime_seconds") / 3600, model::number_of(health, "memory_mb"),
                       model::count_of(health, "mqtt_received"), model::count_of(health, "mqtt_published"),
                       model::count_of(health, "mqtt_queued")));
  for (const auto& device : health.value("devices", json::array()))
    out.line(printable(fmt::format("{} left {} and changed its network address {}", model::text_of(device, "address"),
                                   counted(model::count_of(device, "leaves"), "time"),
                                   counted(model::count_of(device, "address_changes"), "time"))));
}

int show_health(Tool& tool) {
  const auto reply = tool.line().reply_to({{"do", "health"}}, kPatience);
  if (!model::flag_of(reply, "ok")) return refused(reply);
  if (tool.json()) {
    tool.print_json(reply);
  } else {
    print_health(tool, reply);
  }
  return model::flag_of(reply, "healthy") ? kGood : kFailed;
}

}  // namespace

void add_map(Cli& cli, CLI::App* parent) {
  Tool::add(cli, parent,
            {"map", "Show which devices reach which others, and how well; loads the radio for some seconds",
             "  rubicon zigbee map\n"
             "  rubicon zigbee map --json\n"},
            show_map);
  Tool::add(cli, parent, {"health", "Ask Zigbee2MQTT how it is", "  rubicon zigbee health\n"}, show_health);
}

}  // namespace rubicon::cli::zigbee
