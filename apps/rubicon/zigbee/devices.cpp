#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/zigbee/tool.h"
#include "model/json_members.h"
#include "model/json_text.h"

namespace rubicon::cli::zigbee {

namespace {

using nlohmann::json;

struct DeviceOptions {
  std::string device, name;
  bool force = false;
};

std::string count_text(const json& device, const char* member) {
  return device.contains(member) ? fmt::format("{:.0f}", model::number_of(device, member)) : "-";
}

void add_row(const json& device, WallTime now, Table& table) {
  const auto seen = model::time_of(device, "last_seen");
  const auto vendor = model::text_of(device, "vendor");
  const auto available = model::text_of(device, "availability");
  table.row({model::text_of(device, "name"), model::text_of(device, "address"),
             fmt::format("{}{}{}", vendor, vendor.empty() ? "" : " ", model::text_of(device, "model")),
             model::text_of(device, "role"), model::text_of(device, "power"), available.empty() ? "-" : available,
             seen == WallTime{} ? "-" : age_text(seen, now), count_text(device, "link_quality"),
             count_text(device, "points"), model::text_of(device, "why")});
}

int list(Tool& tool) {
  using Kind = Column::Kind;
  Table table({{"NAME", Kind::kText},
               {"ADDRESS", Kind::kKey},
               {"MODEL", Kind::kText, 2},
               {"ROLE", Kind::kWord, 5},
               {"POWER", Kind::kText, 6},
               {"AVAILABLE", Kind::kWord, 1},
               {"HEARD", Kind::kWord, 3},
               {"LINK", Kind::kWord, 4},
               {"POINTS", Kind::kWord, 7},
               {"WHY NOT USABLE", Kind::kText}});
  const auto now = std::chrono::floor<std::chrono::microseconds>(std::chrono::system_clock::now());
  std::uint64_t next = 0;
  std::string why_unlisted;
  for (bool more = true; more;) {
    const auto reply = tool.line().reply_to({{"do", "devices"}, {"from", next}}, kPatience);
    if (!model::flag_of(reply, "ok")) return refused(reply);
    const auto before = next;
    for (const auto& device : reply.value("devices", json::array())) {
      ++next;
      if (tool.json()) tool.out().line(model::dump(device));
      add_row(device, now, table);
    }
    more = model::flag_of(reply, "more") && next > before;
    if (!model::flag_of(reply, "listed")) why_unlisted = model::text_of(reply, "why");
  }
  if (!why_unlisted.empty()) print_error(printable("no list of devices was received: " + why_unlisted));
  if (tool.json()) return why_unlisted.empty() ? kGood : kNotDone;
  if (!table.empty()) tool.out().write(table.text(tool.look()));
  if (!why_unlisted.empty()) return kNotDone;
  if (table.empty()) tool.out().line("no device is paired; `rubicon zigbee permit` lets devices join");
  return kGood;
}

int rename(Tool& tool, const DeviceOptions& options) {
  json request{{"do", "rename"}, {"to", options.name}};
  if (const int code = tool.name_device(request, "device", options.device); code != kGood) return code;
  const auto reply = tool.line().reply_to(std::move(request), kPatience);
  if (!model::flag_of(reply, "ok")) return refused(reply);
  if (tool.json()) {
    tool.print_json(reply);
  } else {
    tool.out().line(
        printable(fmt::format("{} is called {} now", model::text_of(reply, "address"), model::text_of(reply, "name"))));
  }
  return kGood;
}

int remove(Tool& tool, const DeviceOptions& options) {
  json request{{"do", "remove"}, {"force", options.force}};
  if (const int code = tool.name_device(request, "device", options.device); code != kGood) return code;
  const auto reply = tool.line().reply_to(std::move(request), kPatience);
  if (!model::flag_of(reply, "ok")) return refused(reply);
  if (tool.json()) {
    tool.print_json(reply);
  } else {
    tool.out().line(printable(fmt::format("{} is removed", model::text_of(reply, "address"))));
  }
  return kGood;
}

}  // namespace

void add_devices(Cli& cli, CLI::App* parent) {
  Tool::add(cli, parent,
            {"devices", "List all devices and groups of the bridge, also those that cannot be used",
             "  rubicon zigbee devices\n"
             "  rubicon zigbee devices --json\n"},
            list);
  const auto options = std::make_shared<DeviceOptions>();
  auto* app = Tool::add(cli, parent,
                        {"rename", "Give a device or group another friendly name",
                         "  rubicon zigbee rename 0x00124b001000000b bedside\n"},
                        [options](Tool& tool) { return rename(tool, *options); });
  app->add_option("DEVICE", options->device, kDeviceHelp)->required();
  app->add_option("NAME", options->name, "the new name; no + or #, not below bridge/, no /set, /get or /availability")
      ->required();
  app = Tool::add(cli, parent,
                  {"remove", "Remove a device or group from the ZigBee network",
                   "  rubicon zigbee remove bath\n"
                   "  rubicon zigbee remove 00124b0010000009 --force    # a device that does not answer\n"},
                  [options](Tool& tool) { return remove(tool, *options); });
  app->add_option("DEVICE", options->device, kDeviceHelp)->required();
  app->add_flag("--force", options->force, "forget it without its answer; it may still believe to be a member");
}

namespace {

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
      print_error(fmt::format("'{}' is not an option, expected NAME=VALUE", printable(word)));
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
