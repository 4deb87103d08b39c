#pragma once

#include <functional>
#include <string>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/tool_line.h"

namespace rubicon::cli::zigbee {

/// Zigbee2MQTT answers within 10 s, a map takes up to two minutes; the island gives up before we do.
inline constexpr Duration kPatience = std::chrono::seconds(15), kMapPatience = std::chrono::seconds(130);

/// One command that talks to the ZigBee network of an island.
class Tool {
 public:
  using Run = std::function<int(Tool&)>;
  /// Adds `rubicon zigbee <name>` with the options that all of them have.
  static CLI::App* add(Cli& cli, CLI::App* parent, const Cli::Text& text, Run run);

  ToolLine& line() { return *line_; }
  bool json() const { return json_; }
  Output& out() { return line_->out(); }
  Look look() { return {out().has_colour(), out().width()}; }
  /// A reply without the members of the envelope.
  void print_json(nlohmann::json reply);

 private:
  Tool(std::unique_ptr<ToolLine> line, bool json) : line_(std::move(line)), json_(json) {}
  std::unique_ptr<ToolLine> line_;
  bool json_;
};

// Each adds one command of `rubicon zigbee`, or a few that belong together.
void add_permit(Cli& cli, CLI::App* parent);
void add_devices(Cli& cli, CLI::App* parent);
void add_options(Cli& cli, CLI::App* parent);
void add_map(Cli& cli, CLI::App* parent);

}  // namespace rubicon::cli::zigbee
