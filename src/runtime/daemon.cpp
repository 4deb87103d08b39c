#include "runtime/daemon.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <cstdio>
#include <filesystem>

#include "runtime/console.h"
#include "runtime/event_json.h"
#include "runtime/island.h"
#include "runtime/island_state.h"
#include "runtime/live_table.h"
#include "runtime/network_types.h"
#include "runtime/shell.h"
#include "runtime/spdlog_sink.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"
#include "tuples/dds/dds_ecology.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::runtime {

namespace {

using tuples::Handle;

/// Components of the daemon itself; ids above 65535 belong to no island.
constexpr std::uint32_t kFirstComponent = 65536;
constexpr Duration kRedraw = std::chrono::milliseconds(500);
constexpr Duration kPatience = std::chrono::milliseconds(300);
constexpr Duration kDropReport = std::chrono::seconds(1);
constexpr std::size_t kMaxErrorsShown = 50;

/// A standard descriptor that came closed would become the next file or socket we open.
void open_missing_descriptors() {
  while (true) {
    const int descriptor = ::open("/dev/null", O_RDWR);
    if (descriptor > STDERR_FILENO) {
      ::close(descriptor);
      return;
    }
    if (descriptor < 0) return;
  }
}

Result<IslandConfig> load(const std::string& file, const std::vector<std::string>& overrides,
                          base::ConfigErrors& errors) {
  auto root = load_config(file, overrides);
  if (!root) return fail(root.error());
  auto config = read_island_config(*root, network_types(), errors);
  config.directory = std::filesystem::path(file).parent_path().string();
  return config;
}

ScreenSize screen_size() {
  winsize size{};
  if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) < 0 || size.ws_row == 0) return {};
  return {size.ws_row, size.ws_col};
}

/// A running daemon: the loop, the island, and the console component that watches, shows and commands.
class Session {
 public:
  Session(const RunOptions& options, LogSink& log)
      : options_(options),
        log_(log, "daemon"),
        signals_(loop_.context(), SIGTERM, SIGINT),
        hang_up_(loop_.context(), SIGHUP),
        output_(loop_.context(), STDOUT_FILENO, [this] { loop_.stop(); }) {}

  Result<void> prepare(IslandConfig config, LogSink& sink) {
    if (auto opened = open_ecology(config.engine, config.id, sink); !opened) return opened;
    auto state = open_state(config, log_, loop_.scheduler().wall_now());
    if (!state) return fail(std::move(state.error()));
    base::ConfigErrors errors;
    auto island =
        Island::make(std::move(config), loop_.scheduler(), transports_, sink, *ecology_, errors, std::move(*state));
    if (!island) return fail(island.error());
    island_ = std::move(*island);
    auto link = ecology_->join(console_);
    if (!link) return fail(link.error());
    link_ = std::move(*link);
    space_ = std::make_unique<TupleSpace>(console_, loop_.scheduler(), *link_);
    for (const auto& text : options_.watch) {
      auto pattern = Pattern::parse(text);
      if (!pattern) return fail(ErrorCode::kInvalid, fmt::format("--watch: {}", pattern.error().text));
      // In the island's own space: a distant component sees only the latest of a turn, a watcher sees each set.
      watches_.push_back(island_->space().subscribe(
          *pattern, {}, [this](const tuples::Event& event) { put_event(event_line(event)); }));
    }
    return {};
  }

  int exit_code() const { return exit_code_; }

  void run() {
    signals_.async_wait([this](const boost::system::error_code& error, int) {
      if (error) return;
      finish();
      patience_ = loop_.scheduler().after(kPatience, [this] { loop_.stop(); });
    });
    await_hang_up();
    const bool table = options_.watch.empty() && !options_.shell && ::isatty(STDOUT_FILENO);
    if (options_.shell || table) make_shell(table);
    if (table) show_table();
    island_->start();
    keep_good();
    log_.info(
        fmt::format("island {} is up: {} networks", number(island_->config().id), island_->networks().ids().size()));
    loop_.run();
    if (table) std::fputs("\x1b[?25h\x1b[2J\x1b[H", stdout);
    if (output_.dropped() > 0)
      log_.warning(fmt::format("{} lines were dropped: the reader is slow", output_.dropped()));
  }

 private:
  Result<void> open_ecology(const EngineSetup& engine, IslandId id, LogSink& sink) {
    if (!engine.dds) {
      ecology_ = std::make_unique<tuples::MemoryEcology>(loop_.scheduler());
      return {};
    }
    const auto post = [this](std::function<void()> call) { loop_.scheduler().post(std::move(call)); };
    auto dds = tuples::dds::DdsEcology::open(engine.options, loop_.scheduler(), post, sink);
    if (!dds) return fail(dds.error().code, engine.place + dds.error().text);
    (*dds)->watch_displaced([this](OwnerId displaced) {
      log_.error(fmt::format("component {} was there before, in another process: this one ends", number(displaced)));
      exit_code_ = kExitFailed;
      finish();
    });
    // Of all components of all processes the consoles need ids that nobody gave them.
    console_ = OwnerId(kFirstComponent + (static_cast<std::uint32_t>(::getpid()) << 8U) + number(id) % 256);
    ecology_ = std::move(*dds);
    return {};
  }

  /// SIGHUP asks for a reload, as it does of every daemon.
  void await_hang_up() {
    hang_up_.async_wait([this](const boost::system::error_code& error, int) {
      if (error) return;
      std::ignore = reload(false);
      await_hang_up();
    });
  }

  /// Reads the file again; what it would change, or did change. On an error everything runs on as before.
  Result<std::vector<std::string>> reload(bool try_only) {
    base::ConfigErrors errors;
    auto next = load(options_.file, options_.overrides, errors);
    if (next && !errors.empty()) next = fail(ErrorCode::kInvalid, errors.text());
    if (!next) return refused(next.error());
    if (try_only) {
      auto plan = island_->plan(*next, errors);
      return plan ? Result<std::vector<std::string>>(std::move(plan->lines)) : fail(plan.error());
    }
    auto plan = island_->reload(std::move(*next), errors);
    if (!plan) return refused(plan.error());
    for (const auto& line : plan->lines) log_.info("reload: " + line);
    log_.info(fmt::format("reloaded {}: {} changes", options_.file, plan->lines.size()));
    keep_good();
    return std::move(plan->lines);
  }

  Result<std::vector<std::string>> refused(const Error& error) {
    log_.error(fmt::format("{} was not taken, everything runs on as before: {}", options_.file, error.text));
    return fail(error);
  }

  void keep_good() {
    if (auto kept = keep_good_config(island_->config(), options_.file); !kept) log_.warning(kept.error().text);
  }

  /// Stops once everything is written.
  void finish() {
    watches_.clear();
    if (table_) return loop_.stop();
    output_.when_empty([this] { loop_.stop(); });
  }

  void put_event(std::string line) {
    if (output_.event(std::move(line)) || drops_.pending()) return;
    drops_ = loop_.scheduler().after(kDropReport, [this] {
      log_.warning(fmt::format("{} lines were dropped so far: the reader is slow", output_.dropped()));
    });
  }

  void make_shell(bool table) {
    const auto& config = island_->config();
    const auto answer = [this, table](std::string line) {
      if (table) {
        last_answer_ = std::move(line);
      } else {
        output_.answer(std::move(line));
      }
    };
    const auto event = [this, table](std::string line) {
      if (!table) put_event(std::move(line));
    };
    shell_ = std::make_unique<Shell>(*space_, config.id, config.proxy.prefix, answer, event, [this] { finish(); });
    shell_->on_reload([this](bool try_only) { return reload(try_only); });
    // The shell answers from its copies: it starts to read when the first of them is there.
    first_copy_ = space_->subscribe({config.id, "GATEWAY"}, {{}, {}, 0, true}, [this, table](const tuples::Event&) {
      if (!input_) read_input(table);
    });
  }

  void read_input(bool table) {
    ConsoleReader::Calls calls;
    calls.line = [this](std::string_view line) { shell_->line(line); };
    calls.too_long = [this] { shell_->line_too_long(); };
    calls.pause = [this] { return output_.crowded(); };
    calls.end = [this, table] {
      if (table || !options_.watch.empty()) return;  // still something to show
      shell_->when_idle([this] { finish(); });
    };
    input_ = std::make_unique<ConsoleReader>(loop_.context(), STDIN_FILENO, Shell::kMaxLine, std::move(calls));
  }

  void show_table() {
    const auto& config = island_->config();
    table_ = std::make_unique<LiveTable>(*space_, config.id, config.proxy.island_name, config.proxy.prefix);
    // Somebody is looking: this is real demand, and sensors are sampled for it.
    watches_.push_back(space_->subscribe({config.id, config.proxy.prefix + ".**"}, {}, [](const tuples::Event&) {}));
    output_.screen("\x1b[2J");
    redraw();
  }

  void redraw() {
    const auto size = screen_size();
    const auto screen = table_->render(loop_.scheduler().wall_now(), {size.rows - 2, size.columns});
    const auto answer = fitted(last_answer_, static_cast<std::size_t>(size.columns));
    // The cursor stays where the user is typing, on the last line.
    output_.screen(
        fmt::format("\x1b"
                    "7\x1b[H{}\x1b[0m\x1b[{};1H\x1b[2K{}\x1b"
                    "8\x1b[{};1H",
                    screen, size.rows - 1, answer, size.rows));
    redraw_ = loop_.scheduler().after(kRedraw, [this] { redraw(); });
  }

  const RunOptions& options_;
  Log log_;
  transport::Loop loop_;
  transport::LocalTransports transports_{loop_};
  std::unique_ptr<tuples::Ecology> ecology_;
  OwnerId console_{kFirstComponent};
  int exit_code_ = kExitOk;
  boost::asio::signal_set signals_, hang_up_;
  ConsoleWriter output_;
  std::unique_ptr<Island> island_;
  std::unique_ptr<tuples::Link> link_;
  std::unique_ptr<TupleSpace> space_;
  std::vector<Handle> watches_;
  std::unique_ptr<Shell> shell_;
  std::unique_ptr<LiveTable> table_;
  Handle first_copy_;
  std::unique_ptr<ConsoleReader> input_;
  Timer redraw_, patience_, drops_;
  std::string last_answer_;
};

void print_errors(const base::ConfigErrors& errors) {
  const auto& lines = errors.lines();
  for (std::size_t i = 0; i < std::min(lines.size(), kMaxErrorsShown); ++i) fmt::print(stderr, "{}\n", lines[i]);
  if (lines.size() > kMaxErrorsShown) fmt::print(stderr, "... and {} more\n", lines.size() - kMaxErrorsShown);
}

int report(const Error& error) {
  fmt::print(stderr, "{}\n", error.text);
  return error.code == ErrorCode::kIo ? kExitFailed : kExitConfiguration;
}

}  // namespace

int run(const RunOptions& options) {
  open_missing_descriptors();
  std::signal(SIGPIPE, SIG_IGN);  // a closed standard output ends the session by an error of write()
  base::ConfigErrors errors;
  auto config = load(options.file, options.overrides, errors);
  if (!config) return report(config.error());
  if (!errors.empty()) return check(options.file, options.overrides, std::nullopt);
  // Where the table owns the terminal, only what is worth losing a line of it is logged.
  const bool table = options.watch.empty() && !options.shell && ::isatty(STDOUT_FILENO) && ::isatty(STDERR_FILENO);
  SpdlogSink sink(table && options.log_level == "info" ? "error" : options.log_level);
  Session session(options, sink);
  if (auto ready = session.prepare(std::move(*config), sink); !ready) return report(ready.error());
  session.run();
  return session.exit_code();
}

namespace {

/// What a reload of `file` would do to an island that runs with `old_file`.
int print_plan(const std::string& file, const std::string& old_file, const std::vector<std::string>& overrides) {
  base::ConfigErrors errors;
  const auto next = load(file, overrides, errors);
  if (!next) return report(next.error());
  const auto path = old_file.empty() ? good_config_path(*next) : old_file;
  if (path.empty()) {
    fmt::print(stderr, "--diff: no state file, so nothing is kept of the running configuration; name it: --diff OLD\n");
    return kExitConfiguration;
  }
  const auto now = load(path, overrides, errors);
  if (!now) return report(now.error());
  if (!errors.empty()) {
    print_errors(errors);
    return kExitConfiguration;
  }
  const auto plan = plan_reload(*now, *next);
  for (const auto& line : plan.refusals) fmt::print("refused: {}\n", line);
  for (const auto& line : plan.lines) fmt::print("{}\n", line);
  if (plan.refusals.empty() && plan.lines.empty()) fmt::print("nothing would change\n");
  const bool files = std::any_of(next->networks.begin(), next->networks.end(),
                                 [](const auto& setup) { return !setup.type->file_option.empty(); });
  if (files) fmt::print("whether files that options name have changed, `reload try` of the running island says\n");
  return plan.refusals.empty() ? kExitOk : kExitConfiguration;
}

}  // namespace

int check(const std::string& file, const std::vector<std::string>& overrides,
          const std::optional<std::string>& old_file) {
  base::ConfigErrors errors;
  auto config = load(file, overrides, errors);
  if (!config) return report(config.error());
  const auto networks = config->networks.size();
  std::size_t devices = 0;
  for (const auto& [id, rules] : config->proxy.networks) devices += rules.devices.size();
  // Making the networks checks their own keys; nothing is opened.
  base::NullLogSink quiet;
  transport::Loop loop;
  transport::LocalTransports transports(loop);
  tuples::MemoryEcology ecology(loop.scheduler());
  auto island = Island::make(std::move(*config), loop.scheduler(), transports, quiet, ecology, errors);
  if (!errors.empty()) {
    print_errors(errors);
    return kExitConfiguration;
  }
  if (!island) return report(island.error());
  fmt::print("{}: good: {} networks, {} devices named\n", file, networks, devices);
  return old_file ? print_plan(file, *old_file, overrides) : kExitOk;
}

int list_networks() {
  for (const auto& type : network_types()) {
    fmt::print("{}: {}\n", type.name, type.summary);
    std::string_view sample = type.sample_config;
    while (!sample.empty()) {
      const auto end = std::min(sample.find('\n'), sample.size());
      fmt::print("    {}\n", sample.substr(0, end));
      sample.remove_prefix(std::min(end + 1, sample.size()));
    }
    fmt::print("\n");
  }
  return kExitOk;
}

}  // namespace rubicon::runtime
