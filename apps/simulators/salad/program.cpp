#include "apps/simulators/salad/simulator.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>

#include "apps/program/process.h"
#include "base/text.h"
#include "config/config_file.h"
#include "networks/salad/salad_network.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"
#include "transport/transports.h"

namespace rubicon::salad_simulator {

namespace {

constexpr int kFailed = 1;
constexpr int kConfiguration = 2;
constexpr std::size_t kMaxScriptSize = 1 << 20;

struct Arguments {
  std::string table, network, proxy, bind, script, period = "500ms", log_level = "info";
  std::vector<std::string> misbehave;
  int port = -1;
  SimulatorOptions simulator;
};

void describe(CLI::App& app, Arguments& a) {
  app.add_option("FILE", a.table, "devices: the original's properties file, or an island with a salad network (.yaml)")
      ->required();
  app.add_option("--network", a.network, "network of the island [the first of type salad]");
  app.add_option("--listen", a.port, "port for what the proxy sends; 0 = any free one [salad_port of FILE]")
      ->check(CLI::Range(0, 65535));
  app.add_option(
      "--bind", a.bind,
      "numeric address to listen on, `any` for all addresses of the machine [127.0.0.1 if the proxy is on this "
      "machine, else any]");
  app.add_option("--proxy", a.proxy, "HOST:PORT that updates go to [localhost, rubicon_port of FILE]");
  app.add_option("--period", a.period, "time between two publications of all devices")->capture_default_str();
  app.add_option("--script", a.script, "file with timed steps: `at 2s set 7 1`, see README of networks/salad");
  app.add_option("--noise", a.simulator.noise,
                 "numbers vary by up to this, on/off sensors flip with this chance in percent")
      ->check(CLI::Range(0.0, 100.0));
  app.add_option("--misbehave", a.misbehave, "garbage, loss, duplicates, bursts, silence, all")->delimiter(',');
  app.add_flag("--eager", a.simulator.eager, "publish without a start datagram");
  app.add_option("--seed", a.simulator.seed, "of all random numbers")->capture_default_str();
  app.add_option("--log-level", a.log_level, "what goes to standard error")
      ->check(CLI::IsMember({"debug", "info", "warning", "error", "off"}))
      ->capture_default_str();
}

ConfigNode options_naming(const std::string& properties) {
  ConfigNode options, name;
  name.kind = ConfigNode::Kind::kScalar;
  name.text = properties;
  options.kind = ConfigNode::Kind::kMap;
  options.entries.emplace_back("properties", name);
  return options;
}

/// The options of a network in an island's configuration, and the types the site declared there.
Result<ConfigNode> network_options(const Arguments& a, TypeCatalogue& types) {
  auto root = config::load_config(a.table, {});
  if (!root) return fail(root.error());
  base::ConfigErrors reported_by_the_daemon;
  ConfigReader reader(*root, "", reported_by_the_daemon);
  config::read_site_types(reader, types);
  const auto* networks = root->find("networks");
  for (const auto& [id, network] : networks ? networks->entries : std::vector<std::pair<std::string, ConfigNode>>{}) {
    const auto* type = network.find("type");
    if (type == nullptr || type->text != "salad" || (!a.network.empty() && id != a.network)) continue;
    return network;
  }
  return fail(ErrorCode::kNotFound,
              fmt::format("{}: no network of type salad{}{}", a.table, a.network.empty() ? "" : " called ", a.network));
}

Result<networks::salad::SaladOptions> read_options(const Arguments& a, TypeCatalogue& types,
                                                   transport::Transports& transports) {
  const bool yaml = a.table.ends_with(".yaml") || a.table.ends_with(".yml");
  const auto slash = a.table.rfind('/');
  const auto directory = slash == a.table.npos ? std::string() : a.table.substr(0, slash + 1);
  auto node = yaml ? network_options(a, types) : Result<ConfigNode>(options_naming(a.table.substr(slash + 1)));
  if (!node) return fail(node.error());
  base::ConfigErrors errors;
  ConfigReader reader(*node, "", errors);
  auto options = networks::salad::read_salad_options({"salad", IslandId{1}, reader, types, directory}, transports);
  if (!errors.empty()) return fail(ErrorCode::kInvalid, errors.text());
  return options;
}

/// Completes the simulator's options: arguments take precedence over the file.
Result<void> complete(Arguments& a, const networks::salad::SaladOptions& file) {
  auto& options = a.simulator;
  options.port = a.port < 0 ? file.port : static_cast<std::uint16_t>(a.port);
  options.proxy_port = file.own_port;
  if (!a.proxy.empty()) {
    const auto proxy = base::parse_host_port(a.proxy, file.own_port);
    if (!proxy) return fail(ErrorCode::kInvalid, "--proxy: expected HOST:PORT");
    options.proxy_host = proxy->host;
    options.proxy_port = proxy->port;
  }
  if (options.proxy_port == 0) return fail(ErrorCode::kInvalid, "--proxy: expected HOST:PORT, FILE has no fixed port");
  options.bind = a.bind == "any" ? "" : a.bind.empty() ? listening_address(options.proxy_host) : a.bind;
  const auto period = base::parse_duration(a.period);
  if (!period || *period < std::chrono::milliseconds(1))
    return fail(ErrorCode::kInvalid, "--period: expected at least 1ms");
  options.period = *period;
  auto misbehaviours = parse_misbehaviours(a.misbehave);
  if (!misbehaviours) return fail(ErrorCode::kInvalid, "--misbehave: " + misbehaviours.error().text);
  options.misbehaviours = std::move(*misbehaviours);
  return {};
}

int report(const Error& error) {
  fmt::print(stderr, "salad-simulator: {}\n", error.text);
  return error.code == ErrorCode::kBusy || error.code == ErrorCode::kIo ? kFailed : kConfiguration;
}

int run(Arguments& a) {
  transport::Loop loop;
  transport::LocalTransports transports(loop);
  TypeCatalogue types;
  auto file = read_options(a, types, transports);
  if (!file) return report(file.error());
  if (auto complete_ones = complete(a, *file); !complete_ones) return report(complete_ones.error());
  std::vector<Step> script;
  if (!a.script.empty()) {
    auto text = transport::read_text(transports, a.script, kMaxScriptSize);
    auto steps = text ? parse_script(*text) : Result<std::vector<Step>>(fail(text.error()));
    if (!steps) return report({steps.error().code, a.script + ": " + steps.error().text});
    script = std::move(*steps);
  }
  program::SpdlogSink sink(a.log_level);
  Simulator simulator(a.simulator, file->devices, std::move(script), types, loop.scheduler(), transports,
                      Log(sink, "salad-simulator"));
  const transport::Signals signals(loop, {SIGTERM, SIGINT, SIGHUP}, [&loop] { loop.stop(); });
  if (auto opened = simulator.open(); !opened) return report(opened.error());
  fmt::print("{} devices, listening on {}port {}, sending to {}:{}\n", file->devices.size(),
             a.simulator.bind.empty() ? "" : a.simulator.bind + " ", simulator.port(), a.simulator.proxy_host,
             a.simulator.proxy_port);
  std::fflush(stdout);
  loop.run();
  return 0;
}

}  // namespace

int run_program(int argc, char** argv) {
  CLI::App app("SALAD without its flat: publishes the devices of a table to a Rubicon proxy and executes its commands",
               "salad-simulator");
  app.set_version_flag("--version", [] { return program::version_text("salad-simulator"); });
  Arguments arguments;
  describe(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {  // also --help and --version, which end well
    return app.exit(error) == 0 ? 0 : kFailed;
  }
  return run(arguments);
}

}  // namespace rubicon::salad_simulator
