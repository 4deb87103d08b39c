#include "examples/examples_in_text.h"

#include <optional>
#include <regex>
#include <sstream>

namespace rubicon::examples {

namespace {

/// The command line in a line of code, if it is one of ours.
std::optional<std::string> command_in(std::string line) {
  static const std::regex kCommand(
      R"re(^\s*(?:\$ )?(?:build/release/bin/)?((?:rubicon|rubicon-proxy|motes-simulator|salad-simulator|knx-simulator|zigbee-simulator|\./run|printf|curl)(?: .*)?)$)re");
  std::smatch parts;
  if (!std::regex_match(line, parts, kCommand)) return std::nullopt;
  auto command = parts[1].str();
  command.erase(command.find_last_not_of(' ') + 1);
  return is_synopsis(command) ? std::nullopt : std::optional(command);
}

}  // namespace

bool is_synopsis(const std::string& line) {
  static const std::regex kPlaceholder(
      R"re((^|[^A-Za-z_'"])(FILE|EXPORT|OLD|DEVICE|COMMAND|OPTIONS|HOST|WHICH)\b|\.\.\.)re");
  const auto command = line.substr(0, line.find(" #"));
  return std::regex_search(command, kPlaceholder);
}

std::vector<Example> examples_of_page(const std::string& name, const std::string& text) {
  std::vector<Example> found;
  std::istringstream lines(text);
  std::size_t number = 0;
  bool fenced = false;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.find("```") != line.npos) {
      fenced = !fenced;
    } else if (fenced || line.starts_with("    ")) {
      if (auto command = command_in(line)) found.push_back({name + ":" + std::to_string(number), std::move(*command)});
    }
  }
  return found;
}

std::vector<Example> examples_of_help(const std::string& name, const std::string& text) {
  std::vector<Example> found;
  std::istringstream lines(text);
  bool below = false;
  for (std::string line; std::getline(lines, line);) {
    below = below || line.find("xamples:") != line.npos || line.find(".SH EXAMPLES") != line.npos;
    if (!below) continue;
    line = std::regex_replace(line, std::regex(R"re(\\-)re"), "-");
    line = std::regex_replace(line, std::regex(R"re(\\e)re"), R"(\)");
    if (auto command = command_in(line)) found.push_back({name, std::move(*command)});
  }
  return found;
}

}  // namespace rubicon::examples
