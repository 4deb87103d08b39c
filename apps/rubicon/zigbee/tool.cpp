#include "apps/rubicon/zigbee/tool.h"

#include "apps/rubicon/targets/options.h"
#include "model/json_members.h"
#include "networks/zigbee/tool_requests.h"

namespace rubicon::cli {

namespace zigbee {

namespace {

constexpr ToolTags kTags{networks::zigbee::kRequestTag, networks::zigbee::kReplyTag, networks::zigbee::kEventTag,
                         &networks::zigbee::tag_of};

}  // namespace

CLI::App* Tool::add(Cli& cli, CLI::App* parent, const Cli::Text& text, Run run) {
  const auto network = std::make_shared<NetworkChoice>(NetworkChoice{"zigbee"});
  auto* app = cli.command({text.name, text.summary, text.examples, parent},
                          [network, run = std::move(run), name = "zigbee " + text.name](const Settings& settings) {
                            int code = kFailed;
                            auto line = open_tool_line(settings, name, *network, kTags, code);
                            if (!line) return code;
                            Tool tool(std::move(line), settings.json);
                            return ended(tool.out(), run(tool));
                          });
  network->add_to(app, "zigbee-attic");
  return app;
}

int Tool::name_device(nlohmann::json& request, const char* member, const std::string& word) {
  request[member] = word;
  client::KnownNames names{line_->devices(), {}};
  for (auto& device : names.devices) device.area.clear();  // a room does not mean its only device: it may be removed
  const auto found = client::devices_called(names, word);
  if (found.size() > 1) return ambiguous(word, found);
  if (found.size() == 1) request["address"] = found.front().address;
  return kGood;
}

void Tool::print_json(nlohmann::json reply) {
  for (const auto* member : {"id", "ok", "more", "next"}) reply.erase(member);
  out().line(model::dump(reply));
}

}  // namespace zigbee

void add_zigbee(Cli& cli) {
  auto* app =
      cli.app().add_subcommand("zigbee", "Tools for ZigBee: pair, list, rename, remove, set options, map, monitor");
  app->require_subcommand(1);
  app->fallthrough();
  app->get_formatter()->label("SUBCOMMAND", "COMMAND");
  app->footer(
      "Examples:\n"
      "  rubicon zigbee permit --for 2min\n"
      "  rubicon zigbee devices\n"
      "  rubicon zigbee rename 0x00124b001000000b bedroom/remote\n"
      "They talk to Zigbee2MQTT through the running island. A device is named by its address, with or without 0x,\n"
      "by its friendly name, or by the id or name that the island gives it.");
  zigbee::add_permit(cli, app);
  zigbee::add_devices(cli, app);
  zigbee::add_options(cli, app);
  zigbee::add_map(cli, app);
  zigbee::add_monitor(cli, app);
}

}  // namespace rubicon::cli
