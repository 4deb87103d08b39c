#include "apps/simulators/zigbee/simulator.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>

#include "apps/program/process.h"
#include "apps/simulators/zigbee/replay.h"
#include "base/config_reader.h"
#include "base/text.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"
#include "transport/transports.h"

namespace rubicon::zigbee_simulator {

namespace {

constexpr int kFailed = 1;         ///< the broker was lost in the middle of a replay
constexpr int kConfiguration = 2;  ///< an option or a line of the file
constexpr std::size_t kMaxScriptSize = 1 << 20, kMaxTraceSize = 256 << 20, kMaxPasswordSize = 4096;
constexpr std::uint16_t kBrokerPort = 1883;

struct Arguments {
  std::string file, broker = "127.0.0.1:1883", password_file, every, replay, log_level = "warning";
  double speed = 1;
  bool no_availability = false, pessimistic = false;
  SimulatorOptions simulator;
};

void describe(CLI::App& app, Arguments& a) {
  auto& world = a.simulator.world;
  app.add_option("FILE", a.file, "devices and timed steps: examples/zigbee.script, docs/zigbee-simulator.md");
  app.add_option("--broker", a.broker, "HOST[:PORT] of the MQTT broker")->capture_default_str();
  app.add_option("--user", a.simulator.broker.user, "at the broker");
  app.add_option("--password-file", a.password_file, "file with the password of the user");
  app.add_option("--base", world.base, "base topic")->capture_default_str();
  app.add_option("--devices", a.simulator.devices,
                 "number of devices of the built-in models, in addition to those of FILE")
      ->check(CLI::Range(0, 5000));
  app.add_option("--generated", a.simulator.generated, "so many devices with random definitions")
      ->check(CLI::Range(0, 5000));
  app.add_option("--every", a.every, "each device reports so often, for example 500ms [never by itself]");
  app.add_option("--seed", world.seed, "of all random numbers")->capture_default_str();
  app.add_option("--bridge-version", world.version, "version that the bridge names")->capture_default_str();
  app.add_option("--last-seen", world.last_seen, "form of last_seen")
      ->check(CLI::IsMember({"ISO_8601", "ISO_8601_local", "epoch", "disable"}))
      ->capture_default_str();
  app.add_flag("--permit-join", world.permit_join, "joining is permitted for 254 s from the start");
  app.add_flag("--no-availability", a.no_availability, "the bridge does not publish availability");
  app.add_flag("--no-echo", a.pessimistic, "the bridge does not echo sets (optimistic: false)");
  app.add_flag("--nulls", world.nulls, "what a new device did not report yet is null");
  auto* replay = app.add_option("--replay", a.replay, "publish a recorded trace (mosquitto_sub -F %J) and end");
  app.add_option("--speed", a.speed, "times faster than recorded; 0 = at once")
      ->needs(replay)
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  app.add_option("--log-level", a.log_level, "what goes to standard error; info: the messages of clients")
      ->check(CLI::IsMember({"debug", "info", "warning", "error", "off"}))
      ->capture_default_str();
}

int report(const Error& error) {
  fmt::print(stderr, "zigbee-simulator: {}\n", error.text);
  return error.code == ErrorCode::kBusy || error.code == ErrorCode::kIo ? kFailed : kConfiguration;
}

Result<void> complete(Arguments& a, transport::Transports& transports) {
  auto& options = a.simulator;
  const auto broker = base::parse_host_port(a.broker, kBrokerPort);
  if (!broker || broker->host.empty()) return fail(ErrorCode::kInvalid, "--broker: expected HOST[:PORT]");
  options.broker.host = broker->host;
  options.broker.port = broker->port;
  options.world.availability = !a.no_availability;
  options.world.optimistic = !a.pessimistic;
  if (options.world.base.empty() || options.world.base.find_first_of("+#") != std::string::npos)
    return fail(ErrorCode::kInvalid, "--base: expected a topic without + and #");
  if (!a.every.empty()) {
    const auto every = base::parse_duration(a.every);
    if (!every || *every < std::chrono::milliseconds(1))
      return fail(ErrorCode::kInvalid, "--every: expected at least 1ms");
    options.world.every = *every;
  }
  if (a.password_file.empty()) return {};
  auto password = transport::read_text(transports, a.password_file, kMaxPasswordSize);
  if (!password) return fail(password.error());
  options.broker.password = base::trimmed(*password);
  return {};
}

std::string place(const Arguments& a) {
  return fmt::format("{} at {}:{}", a.simulator.world.base, a.simulator.broker.host, a.simulator.broker.port);
}

void say(const std::string& text) {
  fmt::print("{}\n", text);
  std::fflush(stdout);
}

int replay(const Arguments& a, transport::Loop& loop, transport::Transports& transports, const Log& log) {
  const auto text = transport::read_text(transports, a.replay, kMaxTraceSize);
  if (!text) return report(text.error());
  auto messages = read_trace(*text);
  if (!messages) return report({messages.error().code, a.replay + ": " + messages.error().text});
  const auto count = messages->size();
  int code = 0;
  Replay::Options options{a.simulator.world.base, a.simulator.broker, a.speed};
  Replay run(options, std::move(*messages), loop.scheduler(), transports, log, [&](const Result<void>& end) {
    if (!end) code = report({ErrorCode::kIo, end.error().text});
    loop.stop();
  });
  run.started = [&] { say(fmt::format("{} messages, {}", count, place(a))); };
  if (auto opened = run.open(); !opened) return report(opened.error());
  loop.run();
  return code;
}

int simulate(Arguments& a, transport::Loop& loop, transport::Transports& transports, const Log& log) {
  Script script;
  if (!a.file.empty()) {
    const auto text = transport::read_text(transports, a.file, kMaxScriptSize);
    if (!text) return report(text.error());
    auto read = parse_script(*text);
    if (!read) return report({read.error().code, a.file + ": " + read.error().text});
    script = std::move(*read);
  } else if (a.simulator.devices + a.simulator.generated == 0) {
    a.simulator.devices = static_cast<int>(model_names().size());
  }
  Simulator simulator(a.simulator, std::move(script), loop.scheduler(), transports, log);
  simulator.connected = [&] {
    say(fmt::format("{} devices, {}", simulator.world().registry().devices().size(), place(a)));
  };
  if (auto opened = simulator.open(); !opened) return report(opened.error());
  loop.run();
  simulator.world().stop();
  return 0;
}

int run(Arguments& a) {
  transport::Loop loop;
  transport::LocalTransports transports(loop);
  if (auto complete_ones = complete(a, transports); !complete_ones) return report(complete_ones.error());
  program::SpdlogSink sink(a.log_level);
  const Log log(sink, "zigbee-simulator");
  const transport::Signals signals(loop, {SIGTERM, SIGINT, SIGHUP}, [&loop] { loop.stop(); });
  return a.replay.empty() ? simulate(a, loop, transports, log) : replay(a, loop, transports, log);
}

}  // namespace

int run_program(int argc, char** argv) {
  CLI::App app("A Zigbee2MQTT without radio: devices on an MQTT broker that follow a script", "zigbee-simulator");
  app.set_version_flag("--version", [] { return program::version_text("zigbee-simulator"); });
  Arguments arguments;
  describe(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {  // --help and --version too
    return app.exit(error) == 0 ? 0 : kConfiguration;
  }
  return run(arguments);
}

}  // namespace rubicon::zigbee_simulator
