#include <fmt/format.h>

#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/zigbee/tool.h"
#include "model/json_members.h"
#include "networks/zigbee/tool_requests.h"

namespace rubicon::cli::zigbee {

namespace {

using networks::zigbee::kMessageTag, networks::zigbee::kReplyTag, networks::zigbee::kRequestTag;

constexpr ToolTags kMessageTags{kRequestTag, kReplyTag, kMessageTag};

std::string message_line(const nlohmann::json& message) {
  const auto size = fmt::format("({})", counted(model::count_of(message, "bytes"), "byte"));
  const auto text = message.contains("text") ? model::text_of(message, "text") : size;
  return fmt::format("{}  {:<4}{} {}", clock_text(model::time_of(message, "time")),
                     model::text_of(message, "direction"), model::text_of(message, "topic"), text);
}

int monitor(const Settings& settings, const NetworkChoice& choice) {
  int code = kGood;
  const auto line = open_tool_line(settings, "zigbee monitor", choice, kMessageTags, code);
  if (!line) return code;
  line->on_event = [&](const nlohmann::json& message) {
    line->out().line(settings.json ? model::dump(message) : printable(message_line(message)));
  };
  return ended(line->out(), monitor_traffic(*line));
}

}  // namespace

void add_monitor(Cli& cli, CLI::App* parent) {
  const auto choice = std::make_shared<NetworkChoice>(NetworkChoice{"zigbee"});
  auto* app = cli.command({"monitor", "Print the messages between an island and Zigbee2MQTT as they come",
                           "  rubicon zigbee monitor\n"
                           "  rubicon zigbee monitor --network zigbee --json\n",
                           parent},
                          [choice](const Settings& settings) { return monitor(settings, *choice); });
  choice->add_to(app, "zigbee");
}

}  // namespace rubicon::cli::zigbee
