#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/rubicon/tuple_text.h"
#include "apps/rubicon/zigbee/tool.h"
#include "model/json_members.h"
#include "model/json_text.h"

namespace rubicon::cli::zigbee {

namespace {

using nlohmann::json;

struct OptionWords {
  std::string device;
  std::vector<std::string> set;  ///< NAME=VALUE
};

/// JSON as it is; other words are text.
json value_of(const std::string& text) {
  auto value = model::parse_json(text);
  return value.is_discarded() ? json(text) : value;
}

std::string shown(const json& option, const char* member) {
  const auto found = option.find(member);
  if (found == option.end() || found->is_null()) return {};
  return found->is_string() ? found->get<std::string>() : model::dump(*found);
}

std::string expected(const json& option) {
  if (const auto values = option.find("values"); values != option.end() && values->is_array()) {
    std::vector<std::string> words;
    for (const auto& one : *values) words.push_back(one.is_string() ? one.get<std::string>() : model::dump(one));
    return fmt::format("{}", fmt::join(words, "|"));
  }
  const auto minimum = shown(option, "minimum"), maximum = shown(option, "maximum"), unit = shown(option, "unit");
  const auto range = minimum.empty() && maximum.empty() ? "" : fmt::format("{}..{}", minimum, maximum);
  return range.empty() || unit.empty() ? range + unit : range + " " + unit;
}

int print(Tool& tool, const json& reply) {
  if (tool.json()) {
    tool.print_json(reply);
    return kGood;
  }
  using Kind = Column::Kind;
  Table table(
      {{"OPTION", Kind::kKey}, {"VALUE", Kind::kValue}, {"EXPECTED", Kind::kText, 1}, {"MEANING", Kind::kText, 2}});
  for (const auto& option : reply.value("options", json::array()))
    table.row({shown(option, "name"), shown(option, "value"), expected(option), shown(option, "description")});
  tool.out().write(table.empty() ? "the device has no options\n" : table.text(tool.look()));
  if (model::flag_of(reply, "restart_required"))
    tool.out().line("Zigbee2MQTT uses the new values after its next start");
  return kGood;
}

int options_of(Tool& tool, const OptionWords& words) {
  json request{{"do", "options"}};
  for (const auto& word : words.set) {
    const auto equals = word.find('=');
    if (equals == 0 || equals == std::string::npos) {
      print_error(fmt::format("'{}' is no option, expected NAME=VALUE", printable(word)));
      return kUsage;
    }
    request["set"][word.substr(0, equals)] = value_of(word.substr(equals + 1));
  }
  if (const int code = tool.name_device(request, "device", words.device); code != kGood) return code;
  const auto reply = tool.line().reply_to(std::move(request), kPatience);
  return model::flag_of(reply, "ok") ? print(tool, reply) : refused(reply);
}

}  // namespace

void add_options(Cli& cli, CLI::App* parent) {
  const auto words = std::make_shared<OptionWords>();
  auto* app = Tool::add(cli, parent,
                        {"options", "Show or set how Zigbee2MQTT treats a device",
                         "  rubicon zigbee options living/climate\n"
                         "  rubicon zigbee options living/climate temperature_calibration=-0.5\n"},
                        [words](Tool& tool) { return options_of(tool, *words); });
  app->add_option("DEVICE", words->device, kDeviceHelp)->required();
  app->add_option("NAME=VALUE", words->set, "options to set; a value is JSON or a word; null removes it");
}

}  // namespace rubicon::cli::zigbee
