#include "apps/simulators/knx/simulator.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <random>

#include "apps/program/process.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"
#include "transport/transports.h"

namespace rubicon::knx_simulator {

namespace {

constexpr int kFailed = 1;         ///< the system refused something, such as a port that is in use
constexpr int kConfiguration = 2;  ///< an option or a line of the file
constexpr std::size_t kMaxScriptSize = 1 << 20;

struct Arguments {
  std::string file, bind = "127.0.0.1", interface, routing, secure, log_level = "warning";
  bool udp_only = false, no_tunnelling = false;
  SimulatorOptions simulator;
};

void describe(CLI::App& app, Arguments& a) {
  auto& server = a.simulator.server;
  app.add_option("FILE", a.file, "group addresses and timed steps: examples/knx.script, docs/knx-simulator.md")
      ->required();
  app.add_option("--listen", server.at.port, "UDP and TCP port of the tunnelling server; 0 = any free one")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
  app.add_option("--bind", a.bind, "numeric IPv4 address to listen on, `any` for all addresses of the machine")
      ->capture_default_str();
  app.add_option("--tunnels", server.tunnels, "clients at a time, at 1.1.200 and the following addresses")
      ->check(CLI::Range(1, 50))
      ->capture_default_str();
  app.add_option("--name", server.name, "of the server, in its description")->capture_default_str();
  app.add_flag("--udp-only", a.udp_only, "refuse TCP");
  app.add_option("--secure", a.secure, "file with the passwords of KNX IP Secure: plain tunnels are then refused");
  auto* routing = app.add_option("--routing", a.routing, "also a router on this multicast group [224.0.23.12]")
                      ->expected(0, 1)
                      ->default_str("224.0.23.12");
  app.add_option("--interface", a.interface, "IPv4 address of the interface for routing [the system's choice]")
      ->needs(routing);
  app.add_flag("--no-tunnelling", a.no_tunnelling, "only the router")->needs(routing);
  app.add_option("--loss", a.simulator.weather.loss, "share of the tunnel's UDP datagrams that are lost, each way")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--duplicates", a.simulator.weather.duplicate, "share of them that arrive twice")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--seed", a.simulator.seed, "of all random numbers")->capture_default_str();
  app.add_option("--log-level", a.log_level, "what goes to standard error; info: the telegrams of clients")
      ->check(CLI::IsMember({"debug", "info", "warning", "error", "off"}))
      ->capture_default_str();
}

void complete(Arguments& a, bool routing) {
  auto& options = a.simulator;
  options.server.at.address = a.bind == "any" ? "" : a.bind;
  options.server.tcp = !a.udp_only;
  options.tunnelling = !a.no_tunnelling;
  options.weather.seed = static_cast<unsigned>(options.seed);
  if (!routing) return;
  options.routing.emplace();
  if (!a.routing.empty()) options.routing->group.address = a.routing;
  options.routing->interface_address = a.interface;
  options.routing->address = networks::knx::wire::IndividualAddress(options.server.own_address);
  options.routing->seed = std::random_device{}();
}

int report(const Error& error) {
  fmt::print(stderr, "knx-simulator: {}\n", error.text);
  return error.code == ErrorCode::kBusy || error.code == ErrorCode::kIo ? kFailed : kConfiguration;
}

std::string places(const Arguments& a, const Simulator& simulator) {
  std::string text;
  const auto at = simulator.server().local();
  if (a.simulator.tunnelling) text = fmt::format("tunnels at {}port {}", a.bind == "any" ? "" : a.bind + " ", at.port);
  if (a.simulator.routing)
    text += fmt::format("{}routing on {}", text.empty() ? "" : ", ", a.simulator.routing->group.address);
  return text;
}

Result<void> read_passwords(Arguments& a, transport::Transports& transports) {
  if (a.secure.empty()) return {};
  auto text = transport::read_text(transports, a.secure, kMaxScriptSize);
  if (!text) return fail(text.error());
  auto secure = parse_secure_options(*text);
  networks::knx::secure::wipe(*text);
  if (!secure) return fail(secure.error().code, a.secure + ": " + secure.error().text);
  a.simulator.server.secure = std::move(*secure);
  return {};
}

int run(Arguments& a) {
  transport::Loop loop;
  transport::LocalTransports transports(loop);
  if (const auto read = read_passwords(a, transports); !read) return report(read.error());
  const auto text = transport::read_text(transports, a.file, kMaxScriptSize);
  if (!text) return report(text.error());
  auto script = parse_script(*text);
  if (!script) return report({script.error().code, a.file + ": " + script.error().text});
  const auto groups = script->groups.size();
  program::SpdlogSink sink(a.log_level);
  Simulator simulator(a.simulator, std::move(*script), loop.scheduler(), transports, Log(sink, "knx-simulator"));
  const transport::Signals signals(loop, {SIGTERM, SIGINT, SIGHUP}, [&loop] { loop.stop(); });
  if (auto opened = simulator.open(); !opened) return report(opened.error());
  fmt::print("{} group addresses, {}\n", groups, places(a, simulator));
  std::fflush(stdout);
  loop.run();
  return 0;
}

}  // namespace

int run_program(int argc, char** argv) {
  CLI::App app("A KNX line without hardware: a tunnelling server, a router, and devices that follow a script",
               "knx-simulator");
  app.set_version_flag("--version", [] { return program::version_text("knx-simulator"); });
  Arguments arguments;
  describe(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {  // --help and --version too
    return app.exit(error) == 0 ? 0 : kConfiguration;
  }
  complete(arguments, app.count("--routing") > 0);
  return run(arguments);
}

}  // namespace rubicon::knx_simulator
