#include <fmt/format.h>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/device_options.h"
#include "apps/rubicon/tuple_text.h"
#include "model/json_members.h"
#include "model/point_keys.h"

namespace rubicon::cli {

namespace {

struct RenameOptions {
  std::string device, name, area;
  CLI::Option *name_option = nullptr, *area_option = nullptr;  ///< an empty text is given, too

  bool has_name() const { return name_option->count() > 0; }
  bool has_area() const { return area_option->count() > 0; }
};

int rename(Session& session, const RenameOptions& options) {
  if (!options.has_name() && !options.has_area()) {
    print_error("rename: expected a NAME, --area AREA, or both");
    return kUsage;
  }
  client::Device device;
  if (const int code = one_device(session, options.device, device); code != kGood) return code;
  Line given;
  if (options.has_name()) given["name"] = options.name;
  if (options.has_area()) given["area"] = options.area;
  const auto outcome =
      session.client().command(device.island, model::DeviceKey{device.key()}.description(), model::dump(given));
  if (session.json()) {
    Line line;
    line["island"] = number(device.island);
    line["key"] = device.key();
    line.update(given);
    line["state"] = outcome.state;
    line["reason"] = outcome.reason;
    session.out().line(model::dump(line));
  } else if (outcome.good()) {
    const auto name = options.has_name() ? options.name : device.name;
    const auto area = options.has_area() ? options.area : device.area;
    session.out().line(fmt::format("{} is {}{}", name_of(device.island, device.key()),
                                   name.empty() ? "without a given name" : model::quoted(name),
                                   area.empty() ? "" : " in " + model::quoted(area)));
  } else {
    print_error(fmt::format("{}: {}", outcome.state, printable(outcome.reason)));
  }
  return exit_code_of(outcome.state);
}

}  // namespace

void add_rename(Cli& cli) {
  const auto options = std::make_shared<RenameOptions>();
  auto* app = cli.command_in_ecology(
      {"rename", "Give a device a name for people and the area where it is",
       "  rubicon rename dummy-rooms.living 'Living lamp' --area 'Living room'\n"
       "  rubicon rename dummy-rooms.living --area Attic\n"
       "  rubicon rename dummy-rooms.living '' --area ''        # removes both\n"
       "The island keeps both in its state file; keys stay. What its configuration says goes before.\n"},
      [options](Session& session) { return rename(session, *options); });
  app->add_option("DEVICE", options->device, "key part, network.device, whole key, name or address")->required();
  options->name_option = app->add_option("NAME", options->name, "the new name; '' for the device's own again");
  options->area_option = app->add_option("--area", options->area, "room or place; '' for none");
}

}  // namespace rubicon::cli
