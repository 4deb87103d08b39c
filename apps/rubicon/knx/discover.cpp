#include <fmt/format.h>

#include <optional>

#include "apps/rubicon/knx/commands.h"
#include "apps/rubicon/output/tuple_text.h"
#include "model/json_members.h"
#include "networks/knx/line/discovery.h"
#include "transport/asio_scheduler.h"
#include "transport/interfaces.h"
#include "transport/local_transports.h"

namespace rubicon::cli::knx {

namespace {

using networks::knx::line::Discovery;
using networks::knx::line::DiscoveryOptions;
using networks::knx::line::DiscoveryResult;

struct DiscoverOptions {
  std::vector<std::string> hosts, addresses;
  std::uint16_t port = networks::knx::line::kKnxPort;
  bool route_back = false;
};

DiscoveryOptions plan(const DiscoverOptions& options) {
  DiscoveryOptions out;
  for (const auto& host : options.hosts) out.hosts.push_back({host, options.port});
  out.interfaces = options.addresses;
  out.route_back = options.route_back;
  if (!out.interfaces.empty() || !out.hosts.empty()) return out;
  for (const auto& one : transport::ipv4_interfaces()) {
    if (one.has_multicast && !one.is_loopback) out.interfaces.push_back(one.address);
  }
  return out;
}

DiscoveryResult look(DiscoveryOptions options) {
  transport::Loop loop;
  transport::LocalTransports lines(loop);
  DiscoveryResult found;
  const Discovery discovery(loop.scheduler(), lines, std::move(options), [&](DiscoveryResult result) {
    found = std::move(result);
    loop.stop();
  });
  loop.run();
  return found;
}

Line as_json(const networks::knx::line::FoundServer& server) {
  const auto& about = server.description;
  Line line{{"host", server.control.address},
            {"port", server.control.port},
            {"name", about.name},
            {"address", to_string(about.address)},
            {"medium", networks::knx::line::medium_name(about.medium)},
            {"serial", base::to_hex(about.serial)},
            {"mac", base::to_hex(about.mac)}};
  if (about.max_apdu) line["max_apdu"] = *about.max_apdu;
  for (const auto& one : about.families) line["families"][std::to_string(static_cast<int>(one.family))] = one.version;
  line["secure"] = to_string(server.security());
  for (const auto& one : about.secured) line["secured"].push_back(static_cast<int>(one.family));
  for (const auto& slot : about.slots)
    line["tunnels"].push_back({{"address", to_string(slot.address)},
                               {"free", slot.free},
                               {"usable", slot.usable},
                               {"authorised", slot.authorised}});
  return line;
}

/// Control characters are replaced: the server chose its name.
void put(Output& out, const std::string& text) {
  for (std::size_t at = 0; at <= text.size();) {
    const auto end = std::min(text.find('\n', at), text.size());
    out.line(printable(std::string_view(text).substr(at, end - at)));
    at = end + 1;
  }
}

int discover(const Settings& settings, const DiscoverOptions& options) {
  auto wanted = plan(options);
  if (wanted.interfaces.empty() && wanted.hosts.empty()) {
    print_error("this machine has no interface to search on; `--host HOST` asks one host");
    return kFailed;
  }
  const auto result = look(std::move(wanted));
  Output out(1);
  for (const auto& server : result.servers) {
    if (settings.json) {
      out.line(model::dump(as_json(server)));
    } else {
      put(out, networks::knx::line::describe(server));
    }
  }
  for (const auto& problem : result.problems) print_error(printable(problem.text));
  if (result.servers.empty()) print_error("no KNXnet/IP server answers");
  return ended(out, result.servers.empty() ? kNotThere : kGood);
}

}  // namespace

void add_discover(Cli& cli, CLI::App* under) {
  const auto options = std::make_shared<DiscoverOptions>();
  auto* app = cli.command({"discover", "Find KNX IP interfaces and routers",
                           "  rubicon knx discover\n"
                           "  rubicon knx discover --host 192.168.1.10    # where multicast does not arrive\n"
                           "The line `secure` names the services that take KNX IP Secure only.\n",
                           under},
                          [options](const Settings& settings) { return discover(settings, *options); });
  app->add_option("--host", options->hosts, "ask this host for its description")->type_name("HOST");
  app->add_option("--port", options->port, "UDP port of --host")->capture_default_str();
  app->add_option("--address", options->addresses, "search from the interface of this machine with this address")
      ->type_name("ADDRESS");
  app->add_flag("--nat", options->route_back,
                "servers answer to the address they received the request from (behind address translation)");
}

}  // namespace rubicon::cli::knx
