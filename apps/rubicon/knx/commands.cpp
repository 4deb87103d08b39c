#include "apps/rubicon/knx/commands.h"

namespace rubicon::cli {

void add_knx(Cli& cli) {
  auto* app =
      cli.app().add_subcommand("knx", "Tools for KNX: discover, monitor, read, write, import, keyring, decode, encode");
  app->require_subcommand(1);
  app->fallthrough();
  app->get_formatter()->label("SUBCOMMAND", "COMMAND");
  app->footer(
      "Examples:\n"
      "  rubicon knx discover\n"
      "  rubicon knx import flat.csv > flat.yaml\n"
      "  rubicon knx monitor\n"
      "  rubicon knx write 1/0/1 1.001 on\n"
      "monitor, read, write and capture use the line of the running island, as an interface has few tunnels;\n"
      "--direct HOST opens another tunnel.");
  knx::add_discover(cli, app);
  knx::add_bus(cli, app);
  knx::add_import(cli, app);
  knx::add_keyring(cli, app);
  knx::add_convert(cli, app);
}

}  // namespace rubicon::cli
