#include "apps/simulators/motes/program.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <utility>

#include "apps/program/process.h"
#include "apps/simulators/motes/computer.h"
#include "apps/simulators/motes/scaled_scheduler.h"
#include "apps/simulators/motes/world.h"
#include "base/config_reader.h"
#include "base/virtual_scheduler.h"
#include "motes/packet_log.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"
#include "transport/transports.h"

namespace rubicon::motes_simulator {

namespace {

constexpr int kFailed = 1;         ///< system error, such as a port in use or a failed write
constexpr int kConfiguration = 2;  ///< wrong options, or an error in a file they name
constexpr std::size_t kMaxScript = 1 << 20;

struct Arguments {
  std::string board = "EM1000", listen = "127.0.0.1", pty, script, events, record, span = "10min", spacing = "250ms",
              delay = "0ms", report = "1s", sensor_time = "210ms";
  std::uint16_t port = 19202, motes = 5, first = 2;
  double speed = 1;
  bool fast = false, same_ids = false;
  MoteOptions mote;
  WorldOptions world;
};

void describe_world(CLI::App& app, Arguments& a) {
  app.add_option("--motes", a.motes, "motes at each sink")->check(CLI::Range(0, 1000))->capture_default_str();
  app.add_option("--sinks", a.world.sinks, "sinks, each on its own port, counted up from --port")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--first", a.first, "address of the first mote")->check(CLI::Range(2, 60000))->capture_default_str();
  app.add_flag("--same-ids", a.same_ids, "number the motes of each sink from --first instead of counting on");
  app.add_option("--board", a.board, "STANDARD, EM1000, SE1000, or a transducer mask in four hex digits")
      ->capture_default_str();
  app.add_option("--island", a.world.sink.island, "island id compiled into the sinks, until the proxy sets another")
      ->check(CLI::Range(1, 65532))
      ->capture_default_str();
  app.add_option("--sensor-time", a.sensor_time, "duration of a measurement; 0s as in the recordings")
      ->capture_default_str();
  app.add_flag("--obey", a.mote.obey, "extension: motes execute Actuate, and a lit LED adds light");
  app.add_flag("--updates", a.mote.updates,
               "extension: motes answer READ_UPDATES with the readings of all their sensors");
  app.add_flag("--wait", a.world.wait_for_computer,
               "switch the motes of a sink on when a computer has connected to it");
  app.add_flag("--reply-to-all", a.world.sink.reply_to_all,
               "broadcast the replies to joins, so that motes answer those to others with garbage");
  app.add_option("--boot-spacing", a.spacing, "time from one mote's boot to the next")->capture_default_str();
  app.add_option("--loss", a.world.radio.loss, "share of the radio messages that get lost")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--duplicates", a.world.radio.duplicates, "share of the radio messages that arrive twice")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--delay", a.delay, "additional delay of radio messages")->capture_default_str();
  app.add_option("--seed", a.world.seed, "of all random numbers")->capture_default_str();
  app.add_option("--script", a.script, "file with timed steps, such as `at 2s reboot 7`: docs/motes-simulator.md");
}

void describe_line(CLI::App& app, Arguments& a) {
  app.add_option("--port", a.port, "TCP port of the first sink, for source network@HOST:PORT; 0 = any free port")
      ->capture_default_str();
  app.add_option("--listen", a.listen, "numeric address to listen on")->capture_default_str();
  auto* pty =
      app.add_option("--pty", a.pty, "make pseudo-terminals NAME, NAME-2, ... instead, for source serial@NAME:115200");
  app.add_option("--baud", a.world.sink.baud, "baud rate of the serial lines")
      ->check(CLI::Range(300, 4000000))
      ->capture_default_str();
  app.add_option("--events", a.events, "file to append a line of JSON to for each event; - = standard output");
  app.add_option("--record", a.record, "file to append the first sink's packets to, in the original's LOG format");
  app.add_option("--speed", a.speed, "factor of real time")->check(CLI::Range(0.01, 1000.0));
  auto* wait = app.get_option("--wait")->excludes(pty);  // connections to a pseudo-terminal cannot be detected
  auto* fast = app.add_flag("--fast", a.fast, "run as fast as possible, without ports, for recordings");
  fast->excludes(pty)->excludes(wait);
  app.add_option("--for", a.span, "simulated time of a --fast run")->needs(fast)->capture_default_str();
  app.add_option("--report", a.report, "with --fast: report period of each mote")->capture_default_str();
}

Result<Duration> duration_of(const std::string& flag, const std::string& text) {
  const auto span = base::parse_duration(text);
  if (!span)
    return fail(ErrorCode::kInvalid, fmt::format("{} {}: expected a duration such as 500ms, 2s, 10min", flag, text));
  return *span;
}

Result<void> complete(Arguments& a) {
  const auto spacing = duration_of("--boot-spacing", a.spacing);
  if (!spacing) return fail(spacing.error());
  const auto delay = duration_of("--delay", a.delay);
  if (!delay) return fail(delay.error());
  const auto sensor_time = duration_of("--sensor-time", a.sensor_time);
  if (!sensor_time) return fail(sensor_time.error());
  const auto board = parse_build(a.board);
  if (!board)
    return fail(ErrorCode::kInvalid,
                fmt::format("--board {}: expected STANDARD, EM1000, SE1000 or four hex digits", a.board));
  a.world.boot_spacing = *spacing;
  a.world.radio.delay = *delay;
  if (a.world.wait_for_computer) a.world.first_boot = std::chrono::seconds(1);  // the computer sets the island id first
  a.mote.board = *board;
  a.mote.sensor_time = *sensor_time;
  const unsigned last = a.first + a.motes * (a.same_ids ? 1U : a.world.sinks);
  if (last > motes::kBaseMote - 1U)
    return fail(ErrorCode::kInvalid,
                fmt::format("the last mote would have address {}, expected at most 65532", last - 1));
  if (!a.fast && a.pty.empty() && a.port + a.world.sinks > 65536)
    return fail(ErrorCode::kInvalid, "--port: the port of the last sink would exceed 65535");
  for (std::uint16_t sink = 1; sink <= a.world.sinks; ++sink)
    a.world.add_motes(sink, static_cast<std::uint16_t>(a.first + (a.same_ids ? 0 : (sink - 1) * a.motes)), a.motes,
                      a.mote);
  return {};
}

/// The files that events and packets are written to.
struct Outputs {
  std::unique_ptr<transport::AppendFile> events, record;
  std::unique_ptr<motes::PacketLogWriter> packets;
  bool print = false, live = true, lost = false;

  void event(const Event& event) {
    const auto line = to_json(event) + "\n";
    if (print) std::fputs(line.c_str(), stdout);
    if (print && live) flush();
    if (events) check(events->append(base::as_bytes(line)));
  }
  void flush() {
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
      check(fail(ErrorCode::kIo, "cannot write to standard output: events are lost"));
  }
  /// The exit code of a completed run.
  int finish() {
    flush();
    return lost ? kFailed : 0;
  }
  void check(const Result<void>& written) {
    if (!written && !std::exchange(lost, true)) fmt::print(stderr, "motes-simulator: {}\n", written.error().text);
  }
};

Result<void> open_outputs(const Arguments& a, transport::Transports& transports, Outputs& out) {
  out.print = a.events == "-";
  out.live = !a.fast;
  if (!a.events.empty() && !out.print) {
    auto file = transports.open_append(a.events);
    if (!file) return fail(file.error());
    out.events = std::move(*file);
  }
  if (a.record.empty()) return {};
  Bytes beginning(64);
  auto there = transports.open_file(a.record);
  const auto count = there ? (*there)->read(beginning) : Result<std::size_t>(0);  // otherwise it is created
  if (!count) return fail(count.error());
  if (const auto valid = motes::check_packet_log(ByteView(beginning).first(*count)); !valid)
    return fail(valid.error().code, a.record + ": " + valid.error().text);
  auto file = transports.open_append(a.record);
  if (!file) return fail(file.error());
  out.record = std::move(*file);
  out.packets = std::make_unique<motes::PacketLogWriter>(*out.record);
  return {};
}

std::unique_ptr<World> make_world(const Arguments& a, std::vector<Step> script, Scheduler& scheduler, Outputs& out) {
  EventLog::Callback events;
  if (out.print || out.events) events = [&out](const Event& event) { out.event(event); };
  auto world = std::make_unique<World>(a.world, scheduler, std::move(script), std::move(events));
  if (!out.packets) return world;
  world->sink(1).watch([&out, &scheduler](bool written, ByteView packet) {
    const auto at = std::chrono::duration_cast<std::chrono::milliseconds>(scheduler.wall_now().time_since_epoch());
    out.check(
        out.packets->write(at, written ? motes::PacketDirection::kWritten : motes::PacketDirection::kRead, packet));
  });
  return world;
}

int report(const Error& error) {
  fmt::print(stderr, "motes-simulator: {}\n", error.text);
  return error.code == ErrorCode::kBusy || error.code == ErrorCode::kIo ? kFailed : kConfiguration;
}

int run_fast(const Arguments& a, std::vector<Step> script, Outputs& out) {
  const auto span = duration_of("--for", a.span);
  const auto period = duration_of("--report", a.report);
  if (!span || !period) return report(!span ? span.error() : period.error());
  const double count = std::chrono::duration<double>(*period).count() * 1024;
  if (count < 1 || count > 65535) return report({ErrorCode::kInvalid, "--report: expected 1ms to 64s"});
  VirtualScheduler time;
  const auto world = make_world(a, std::move(script), time, out);
  std::vector<std::unique_ptr<Computer>> computers;
  for (std::uint16_t sink = 1; sink <= world->sinks(); ++sink)
    computers.push_back(std::make_unique<Computer>(
        ComputerOptions{a.world.sink.island, static_cast<std::uint16_t>(count), a.mote.updates}, world->sink(sink),
        time));
  time.run_for(*span);
  return out.finish();
}

Result<void> open_ports(const Arguments& a, World& world, transport::Transports& transports) {
  for (std::uint16_t sink = 1; sink <= world.sinks(); ++sink) {
    const auto name = sink == 1 ? a.pty : fmt::format("{}-{}", a.pty, sink);
    const auto port = static_cast<std::uint16_t>(a.port == 0 ? 0 : a.port + sink - 1);
    const auto opened = a.pty.empty()
                            ? world.open(sink, on_tcp(transports, {a.listen, port},
                                                      [sink](const transport::Endpoint& at) {
                                                        fmt::print("sink {}: network@{}\n", sink, to_string(at));
                                                        std::fflush(stdout);
                                                      }))
                            : world.open(sink, on_pty(transports, name));
    if (!opened) return opened;
    if (!a.pty.empty()) fmt::print("sink {}: serial@{}:{}\n", sink, name, a.world.sink.baud);
  }
  std::fflush(stdout);
  return {};
}

Result<std::vector<Step>> read_script(const Arguments& a, transport::Transports& transports) {
  if (a.script.empty()) return std::vector<Step>();
  const auto text = transport::read_text(transports, a.script, kMaxScript);
  if (!text) return fail(text.error());
  auto steps = parse_script(*text);
  if (!steps) return fail(steps.error().code, a.script + ": " + steps.error().text);
  if (const auto valid = check_script(*steps, a.world); !valid)
    return fail(valid.error().code, a.script + ": " + valid.error().text);
  return steps;
}

int run(Arguments& a) {
  transport::Loop loop;
  transport::LocalTransports transports(loop);
  if (const auto completed = complete(a); !completed) return report(completed.error());
  auto script = read_script(a, transports);
  if (!script) return report(script.error());
  Outputs out;
  if (const auto opened = open_outputs(a, transports, out); !opened) return report(opened.error());
  if (a.fast) return run_fast(a, std::move(*script), out);
  ScaledScheduler scaled(loop.scheduler(), a.speed);
  Scheduler& scheduler = a.speed == 1 ? static_cast<Scheduler&>(loop.scheduler()) : scaled;
  const auto world = make_world(a, std::move(*script), scheduler, out);
  const transport::Signals signals(loop, {SIGTERM, SIGINT, SIGHUP}, [&loop] { loop.stop(); });
  if (const auto opened = open_ports(a, *world, transports); !opened) return report(opened.error());
  loop.run();
  return out.finish();
}

}  // namespace

int run_program(int argc, char** argv) {
  CLI::App app("Simulates sinks and motes with the original firmware on TCP ports or pseudo-terminals",
               "motes-simulator");
  app.set_version_flag("--version", [] { return program::version_text("motes-simulator"); });
  Arguments arguments;
  describe_world(app, arguments);
  describe_line(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {  // also --help and --version, with exit code 0
    return app.exit(error) == 0 ? 0 : kConfiguration;
  }
  return run(arguments);
}

}  // namespace rubicon::motes_simulator
