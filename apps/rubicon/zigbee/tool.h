#pragma once

#include <functional>
#include <string>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/tool_line.h"

namespace rubicon::cli::zigbee {

/// Zigbee2MQTT answers within 10 s, a map takes up to two minutes; the island gives up before we do.
inline constexpr Duration kPatience = std::chrono::seconds(15), kMapPatience = std::chrono::seconds(130);

/// What `DEVICE` may be, for the help of a command.
inline constexpr const char* kDeviceHelp = "friendly name, address, or the id or name that the island gives it";

/// One command that talks to the ZigBee network of an island.
class Tool {
 public:
  using Run = std::function<int(Tool&)>;
  /// Adds `rubicon zigbee <name>` with the options that all of them have.
  static CLI::App* add(Cli& cli, CLI::App* parent, const Cli::Text& text, Run run);

  Tool(std::unique_ptr<ToolLine> line, bool json) : line_(std::move(line)), json_(json) {}

  ToolLine& line() { return *line_; }
  bool json() const { return json_; }
  Output& out() { return line_->out(); }
  Look look() { return {out().has_colour(), out().width()}; }
  /// Names a device in a request: `member` is the word that was typed, `address` that of the device to which the island
  /// gives it as its id or name, if there is one. kGood; kUsage after printing that `word` means several devices.
  int name_device(nlohmann::json& request, const char* member, const std::string& word);
  /// A reply without the members of the envelope.
  void print_json(nlohmann::json reply);

 private:
  std::unique_ptr<ToolLine> line_;
  bool json_;
};

// Each adds one command of `rubicon zigbee`, or a few that belong together.
void add_permit(Cli& cli, CLI::App* parent);
void add_devices(Cli& cli, CLI::App* parent);
void add_options(Cli& cli, CLI::App* parent);
void add_map(Cli& cli, CLI::App* parent);
void add_monitor(Cli& cli, CLI::App* parent);

/// After a permit: prints what joins until joining is closed, by time, by another client or by an interrupt. `id` is
/// that of the permit's reply. kGood, or kNotDone after the reason was printed.
int watch_joins(Tool& tool, const std::string& id);

}  // namespace rubicon::cli::zigbee
