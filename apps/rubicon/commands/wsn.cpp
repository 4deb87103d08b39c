#include <fmt/format.h>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/tool_line.h"
#include "model/json_members.h"
#include "model/json_text.h"

namespace rubicon::cli {

namespace {

/// docs/motes.md, "Watching packets".
constexpr ToolTags kPacketTags{"wsn.request", "wsn.reply", "wsn.packet"};

std::string packet_line(const nlohmann::json& packet) {
  return fmt::format("{}  {:<4}{:<12}{}", clock_text(model::time_of(packet, "time")),
                     model::text_of(packet, "direction"), model::text_of(packet, "kind"),
                     model::text_of(packet, "text"));
}

int monitor_packets(const Settings& settings, const NetworkChoice& choice) {
  int code = kGood;
  const auto line = open_tool_line(settings, "wsn monitor", choice, kPacketTags, code);
  if (!line) return code;
  line->on_event = [&](const nlohmann::json& packet) {
    line->out().line(settings.json ? model::dump(packet) : printable(packet_line(packet)));
  };
  return ended(line->out(), monitor_traffic(*line));
}

}  // namespace

void add_wsn(Cli& cli) {
  auto* parent = cli.app().add_subcommand("wsn", "Tools for motes: monitor");
  parent->require_subcommand(1);
  parent->fallthrough();
  parent->get_formatter()->label("SUBCOMMAND", "COMMAND");
  parent->footer("Examples:\n  rubicon wsn monitor --network wsn-1\n");
  const auto choice = std::make_shared<NetworkChoice>(NetworkChoice{"wsn"});
  auto* app = cli.command({"monitor", "Print the packets between an island and its motes as they come",
                           "  rubicon wsn monitor --network wsn-1\n"
                           "  rubicon wsn monitor --network wsn-1 --json\n",
                           parent},
                          [choice](const Settings& settings) { return monitor_packets(settings, *choice); });
  choice->add_to(app, "wsn-1");
}

}  // namespace rubicon::cli
