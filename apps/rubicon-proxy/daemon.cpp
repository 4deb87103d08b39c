#include "apps/rubicon-proxy/daemon.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <cstdio>
#include <utility>

#include "apps/program/process.h"
#include "apps/rubicon-proxy/check.h"
#include "apps/rubicon-proxy/duplicate_id.h"
#include "apps/rubicon-proxy/engine_setup.h"
#include "apps/rubicon-proxy/knx_importer.h"
#include "apps/rubicon-proxy/parts.h"
#include "apps/rubicon-proxy/service_notice.h"
#include "console/console.h"
#include "console/shell.h"
#include "island/island.h"
#include "island/island_state.h"
#include "island/island_tuples.h"
#include "island/network_types.h"
#include "island/rights_checks.h"
#include "island/spare_memory.h"
#include "rubicon/summary.hpp"
#include "transport/asio_scheduler.h"
#include "transport/host_names.h"
#include "transport/local_transports.h"
#include "transport/machine_sockets.h"
#include "trust/site/live_realm.h"
#include "tuples/engines/engines.h"
#include "tuples/memory/memory_ecology.h"
#include "tuples/peer_policy.h"
#include "tuples/tuple_json.h"

namespace rubicon::daemon {

namespace {

using tuples::Handle;

/// Components of the daemon itself; ids above 65535 belong to no island.
constexpr std::uint32_t kFirstComponent = 65536;
/// Each with an id of its own. All are below 2^31, as PEIS requires: the number of a process has 22 bits (proc(5)).
enum class Part : std::uint32_t { kConsole = 0, kPage = 1, kHistory = 2, kBridge = 3 };

OwnerId component_id(Part part, IslandId island) {
  const auto process = static_cast<std::uint32_t>(::getpid()) & 0x3f'ffff;
  return OwnerId(kFirstComponent + (static_cast<std::uint32_t>(part) << 29U) + (process << 7U) + number(island) % 128);
}

constexpr Duration kLastPause = std::chrono::milliseconds(300);
constexpr Duration kDropReport = std::chrono::seconds(1);
/// This time after a start or a reload the devices of the networks have their tuples.
constexpr Duration kSettled = std::chrono::seconds(10);

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

/// A running daemon: the loop, the island, and the console component that watches, shows and commands.
class Session {
 public:
  Session(const RunOptions& options, transport::Loop& loop, LogSink& unpublished, island::LogLines& lines)
      : options_(options),
        unpublished_(unpublished),
        lines_(lines),
        log_(lines, "daemon"),
        loop_(loop),
        signals_(loop_.context(), SIGTERM, SIGINT),
        hang_up_(loop_.context(), SIGHUP),
        output_(loop_.context(), STDOUT_FILENO, [this] { loop_.stop(); }) {}

  Result<void> prepare(island::IslandConfig config) {
    judge_ = island::make_judge(config);
    for (const auto& text : config.engine.warnings) log_.warning(text);
    for (const auto& text : held_back_lines(config.engine)) log_.warning(text);
    if (auto kept = judge_ ? audit_.take(config, *judge_) : Result<void>(); !kept) return kept;
    if (auto opened = open_ecology(config, lines_); !opened) return opened;
    await_signal();
    if (auto joined = join_console(); !joined) return joined;
    if (auto alone = be_alone(config); !alone) return alone;
    auto state = island::open_state(config, log_, loop_.scheduler().wall_now());
    if (!state) return fail(std::move(state.error()));
    base::ConfigErrors errors;
    const auto id = config.id;
    auto island = island::Island::make(std::move(config), loop_.scheduler(), transports_, lines_, *ecology_, errors,
                                       std::move(*state));
    if (!island && island.error().code == ErrorCode::kDuplicate) island.error().text += way_out(id);
    if (!island) return fail(island.error());
    island_ = std::move(*island);
    island_->show_log(lines_);
    if (judge_) island_->judge_by(judge_, unpublished_);
    if (realm_)  // behind the engine, which knows the new members then
      realm_changes_ = realm_->watch([this] { tuples::SpaceRights::rejudge(island_->space()); });
    if (engines_ && engines_->dds()) show_interfaces(*island_, *engines_->dds());
    island_->settings().on_reload([this](bool try_only) { return reload(try_only); });
    if (const auto text = desk_.read()) desk_.took(*text);
    island_->settings().change_by(desk_);
    importer_ = std::make_unique<KnxImporter>(loop_.scheduler(), transports_, *island_);
    island::give_back_memory();
    past_ = std::make_unique<HistoryPart>(HistoryPart::Host{loop_.scheduler(), *ecology_, lines_, island_->space(),
                                                            island_->config().proxy.prefix, island_->gateway()},
                                          component_id(Part::kHistory, island_->config().id));
    page_ =
        std::make_unique<WebPart>(WebPart::Host{loop_, *ecology_, transports_, lines_, island_->config().id, *importer_,
                                                island_->config().engine.closed},
                                  component_id(Part::kPage, island_->config().id), island_->config().proxy.island_name);
    bridges_ = std::make_unique<BridgesPart>(BridgesPart::Host{
        loop_.scheduler(), *ecology_, transports_, lines_, *island_, audit_, judge_,
        [](std::size_t place) { return component_id(Part::kBridge, IslandId{static_cast<std::uint32_t>(place)}); }});
    for (const auto& text : options_.watch) {
      auto pattern = Pattern::parse(text);
      if (!pattern) return fail(ErrorCode::kInvalid, fmt::format("--watch: {}", pattern.error().text));
      // In the island's own space: a distant component sees only the latest of a turn, a watcher sees each set.
      watches_.push_back(island_->space().subscribe(
          *pattern, {}, [this](const tuples::Event& event) { put_event(tuples::event_line(event)); }));
    }
    return {};
  }

  int exit_code() const { return exit_code_; }

  void run() {
    await_hang_up();
    if (options_.shell) make_shell();
    island_->start();
    open_parts();
    // A turn later the tuples are there and others see the island.
    loop_.scheduler().post([this] { service_.ready(status()); });
    keep_good();
    // Frees the memory that the joins of many devices took. The memory for reading the configuration was freed before.
    settled_ = loop_.scheduler().after(kSettled, island::give_back_memory);
    const auto open = who_may_command(island_->config());
    log_.info(fmt::format("island {} is up: {}{}", number(island_->config().id), networks_text(),
                          open.empty() ? "" : "; " + open));
    if (options_.watch.empty() && !options_.shell && ::isatty(STDOUT_FILENO) == 1) output_.answer(where_to_look());
    loop_.run();
    if (output_.dropped() > 0)
      log_.warning(fmt::format("{} lines were dropped: the reader is slow", output_.dropped()));
  }

 private:
  Result<void> open_ecology(const island::IslandConfig& config, LogSink& sink) {
    const auto& engine = config.engine;
    console_ = component_id(Part::kConsole, config.id);
    if (engine.alone()) {
      ecology_ = std::make_unique<tuples::MemoryEcology>(loop_.scheduler());
      return {};
    }
    if (auto opened = open_engines(config, sink); !opened)
      return fail(opened.error().code, engine.place + opened.error().text);
    return {};
  }

  Result<void> open_engines(const island::IslandConfig& config, LogSink& sink) {
    const auto& engine = config.engine;
    const auto displaced = [this](OwnerId id) {
      const auto* dds = engines_ ? engines_->dds() : nullptr;
      log_.error(displaced_text(id, dds ? dds->component_starts() : std::vector<tuples::dds::ComponentStart>()));
      exit_code_ = kExitFailed;
      finish();
    };
    const auto post = [this](std::function<void()> call) { loop_.scheduler().post(std::move(call)); };
    tuples::engines::EngineOptions options;
    if (engine.host) {
      auto setup = host_setup(engine);
      if (!setup) return fail(std::move(setup.error()));
      options.host = std::move(*setup);
      // Without rights every user who may enter the folder may do everything.
      if (config.rights) options.host->options.judge = judge_;
    }
    if (engine.dds) {
      options.dds = engine.options;
      if (config.rights) options.dds->judge = judge_;
    }
    if (engine.mqtt) {
      auto space = engine.mqtt_space.options(transports_);
      if (!space) return fail(ErrorCode::kIo, "tuples.mqtt.broker: " + space.error().text);
      options.mqtt = std::move(*space);
      const auto& broker = options.mqtt->brokers.front();
      auto realm = trust::site::LiveRealm::open(broker.line.tls ? broker.line.tls->ca_file : "", broker.user,
                                                loop_.scheduler(), Log(lines_, "mqtt"));
      if (!realm) return fail(std::move(realm.error()));
      options.mqtt->realm = realm_ = std::move(*realm);
      if (config.rights || realm_) options.mqtt->judge = judge_;
    }
    if (engine.peis) options.peis = engine.peis_options;
    if (options.peis) options.peis->judge = judge_;
    options.carrier = config.id;
    options.carry = engine.carry;
    auto engines = tuples::engines::Engines::open(
        options,
        {loop_.scheduler(), post, transports_, sink, transport::netlink_interfaces(transport::asio_watch(loop_))});
    if (!engines) return fail(engines.error());
    (*engines)->watch_displaced(displaced);
    engines_ = engines->get();
    ecology_ = std::move(*engines);
    return {};
  }

  Result<void> join_console() {
    auto link = ecology_->join(console_);
    if (!link) return fail(link.error());
    link_ = std::move(*link);
    space_ = std::make_unique<TupleSpace>(console_, loop_.scheduler(), *link_);
    spare_memory_ = std::make_unique<island::SpareMemory>(loop_.scheduler());
    const Summary console{kConsole, transport::host_name(), transport::own_process(), "", loop_.scheduler().wall_now()};
    return space_->describe(model::to_json(console));
  }

  /// A second start opens no line and publishes nothing. On the host the lock of the id decides.
  Result<void> be_alone(const island::IslandConfig& config) {
    if (!engines_) return {};
    auto alone = engines_->check_free(config.id);
    if (alone)
      alone =
          await_alone(loop_, *engines_, *space_, config.id, config.engine.options.lease, [this] { return finishing_; });
    if (!alone && alone.error().code == ErrorCode::kDuplicate) alone.error().text += way_out(config.id);
    return alone;
  }

  /// The first one ends the island; one that comes while it ends, no longer waits for a slow reader.
  void await_signal() {
    signals_.async_wait([this](const boost::system::error_code& error, int) {
      if (error) return;
      hurried_ = true;
      finish();
      if (closed_) stop_after_pause();
      await_signal();
    });
  }

  /// SIGHUP asks for a reload, as it does of every daemon.
  void await_hang_up() {
    hang_up_.async_wait([this](const boost::system::error_code& error, int) {
      if (error) return;
      std::ignore = reload_and_show(false);
      await_hang_up();
    });
  }

  /// One line for people who ask the service manager.
  std::string status() const {
    const auto& config = island_->config();
    const auto up =
        fmt::format("island {} ({}) is up: {}", number(config.id), config.proxy.island_name, networks_text());
    const auto lines = held_back_lines(config.engine);
    return lines.empty() ? up : fmt::format("{}; {}", up, fmt::join(lines, "; "));
  }

  std::string networks_text() const {
    const auto count = island_->networks().ids().size();
    return fmt::format("{} network{}", count, count == 1 ? "" : "s");
  }

  /// The request comes from a signal, the shell, or a command of the settings, which shows the outcome itself.
  Result<std::vector<std::string>> reload(bool try_only) {
    if (try_only) return take_file(true);
    service_.reloading();
    auto taken = take_file(false);
    service_.ready(taken ? status() : status() + "; the last reload was refused: " + taken.error().text);
    return taken;
  }

  Result<std::vector<std::string>> reload_and_show(bool try_only) {
    auto outcome = reload(try_only);
    island_->settings().show_outcome(try_only, outcome);
    return outcome;
  }

  /// Reads the file again; what it would change, or did change. On an error nothing changes.
  Result<std::vector<std::string>> take_file(bool try_only) {
    if (!try_only) audit_.reopen();
    const auto text = desk_.read();
    if (!text) return refused(text.error());
    if (try_only) {
      auto plan = plan_text(*text);
      return plan ? plan : refused(plan.error());
    }
    base::ConfigErrors errors;
    auto next = load_text(*text, errors);
    if (!next) return refused(next.error());
    auto plan = island_->reload(std::move(*next), errors);
    if (!plan) return refused(plan.error());
    desk_.took(*text);
    for (const auto& line : plan->lines) log_.info("reload: " + line);
    for (const auto& line : plan->warnings) log_.warning("reload: " + line);
    log_.info(
        fmt::format("reloaded {}: {} change{}", options_.file, plan->lines.size(), plan->lines.size() == 1 ? "" : "s"));
    keep_good();
    open_parts();
    island::give_back_memory();
    settled_ = loop_.scheduler().after(kSettled, island::give_back_memory);
    return all_lines(std::move(*plan));
  }

  Result<island::IslandConfig> load_text(const std::string& text, base::ConfigErrors& errors) const {
    auto next = load_island_text(text, options_.file, options_.overrides, errors);
    if (next && !errors.empty()) return fail(ErrorCode::kInvalid, errors.text());
    return next;
  }

  /// What a reload of this text would do.
  Result<std::vector<std::string>> plan_text(const std::string& text) {
    base::ConfigErrors errors;
    const auto next = load_text(text, errors);
    if (!next) return fail(next.error());
    auto plan = island_->plan(*next, errors);
    return plan ? Result<std::vector<std::string>>(all_lines(std::move(*plan))) : fail(plan.error());
  }

  static std::vector<std::string> all_lines(island::ReloadPlan plan) {
    for (const auto& line : plan.warnings) plan.lines.push_back("warning: " + line);
    return std::move(plan.lines);
  }

  Result<std::vector<std::string>> refused(const Error& error) {
    log_.error(fmt::format("{} rejected; the running configuration stays: {}", options_.file, error.text));
    return fail(error);
  }

  /// What runs beside the island.
  void open_parts() {
    const auto& config = island_->config();
    if (const auto kept = judge_ ? audit_.take(config, *judge_) : Result<void>(); !kept)
      log_.warning(fmt::format("{}; the audit continues as before", kept.error().text));
    // The page shows the history: it ends before that.
    if (!past_->has(config.history)) page_->take(std::nullopt, {}, nullptr);
    past_->take(config.history, config.directory);
    page_->take(config.web, config.directory, past_->history());
    bridges_->take();
  }

  void keep_good() {
    if (auto kept = island::keep_good_config(island_->config(), options_.file); !kept) log_.warning(kept.error().text);
  }

  /// Stops once the devices have heard that it ends, and everything is written.
  void finish() {
    if (std::exchange(finishing_, true) || !island_) return;
    service_.stopping("last commands to devices, then writing what is not on the disk yet");
    watches_.clear();
    page_.reset();
    bridges_.reset();
    island_->close([this] {
      past_.reset();  // has the last values
      closed_ = true;
      output_.when_empty([this] { loop_.stop(); });
      if (hurried_) stop_after_pause();
    });
  }

  /// A reader that does not read has this long.
  void stop_after_pause() {
    if (!last_pause_.pending()) last_pause_ = loop_.scheduler().after(kLastPause, [this] { loop_.stop(); });
  }

  void put_event(std::string line) {
    if (output_.event(std::move(line)) || drops_.pending()) return;
    drops_ = loop_.scheduler().after(kDropReport, [this] {
      log_.warning(fmt::format("{} lines were dropped so far: the reader is slow", output_.dropped()));
    });
  }

  /// For people at the terminal on which the island was started.
  std::string where_to_look() const {
    std::vector<std::string> all;
    if (!island_->config().engine.alone()) all.emplace_back("`rubicon top`");
    if (auto page = page_->address(); !page.empty()) all.push_back(std::move(page));
    if (all.empty()) all.emplace_back("only by --watch and --shell (engine memory)");
    return fmt::format("values: {}", fmt::join(all, ", "));
  }

  void make_shell() {
    const auto& config = island_->config();
    shell_ = std::make_unique<console::Shell>(
        loop_.scheduler(), *space_, config.id, config.proxy.prefix,
        [this](std::string line) { output_.answer(std::move(line)); },
        [this](std::string line) { put_event(std::move(line)); }, [this] { finish(); });
    shell_->on_reload([this](bool try_only) { return reload_and_show(try_only); });
    // The shell answers from its copies: it starts to read when the first of them is there.
    first_copy_ = space_->subscribe({config.id, "GATEWAY"}, {{}, {}, 0, true}, [this](const tuples::Event&) {
      if (!input_) read_input();
    });
  }

  void read_input() {
    console::ConsoleReader::Callbacks calls;
    calls.line = [this](std::string_view line) { shell_->line(line); };
    calls.too_long = [this] { shell_->line_too_long(); };
    calls.pause = [this] { return output_.crowded(); };
    calls.end = [this] {
      if (!options_.watch.empty()) return;  // still something to show
      shell_->when_idle([this] { finish(); });
    };
    input_ = std::make_unique<console::ConsoleReader>(loop_.context(), STDIN_FILENO, console::Shell::kMaxLine,
                                                      std::move(calls));
  }

  const RunOptions& options_;
  LogSink& unpublished_;     ///< behind `lines_`: what only the user of the island may see
  island::LogLines& lines_;  ///< what all parts of the program log to
  Log log_;
  transport::Loop& loop_;
  ServiceNotice service_{loop_.scheduler(), ServiceSettings::from_environment()};
  transport::LocalTransports transports_{loop_};
  std::shared_ptr<rights::RightsJudge> judge_;  ///< null: no member is judged
  AuditPart audit_{loop_.scheduler(), lines_, unpublished_};
  std::shared_ptr<trust::site::LiveRealm> realm_;  ///< null: the island has no broker, or no realm
  Handle realm_changes_;
  std::unique_ptr<tuples::Ecology> ecology_;
  tuples::engines::Engines* engines_ = nullptr;  ///< the same; null: within this process only
  OwnerId console_{};
  int exit_code_ = kExitOk;
  bool finishing_ = false;
  bool closed_ = false;   ///< the devices have heard that it ends
  bool hurried_ = false;  ///< a signal asked for the end
  boost::asio::signal_set signals_, hang_up_;
  console::ConsoleWriter output_;
  island::ConfigDesk desk_{
      options_.file,
      {[this](const std::string& text) { return plan_text(text); }, [this] { return reload(false); },
       [this](const std::string& network) { return island_->networks().find(network) != nullptr; }}};
  std::unique_ptr<island::Island> island_;
  std::unique_ptr<KnxImporter> importer_;  ///< ends after the page
  std::unique_ptr<tuples::Link> link_;
  std::unique_ptr<TupleSpace> space_;
  std::unique_ptr<island::SpareMemory> spare_memory_;
  std::unique_ptr<HistoryPart> past_;
  std::unique_ptr<WebPart> page_;
  std::unique_ptr<BridgesPart> bridges_;
  std::vector<Handle> watches_;
  std::unique_ptr<console::Shell> shell_;
  Handle first_copy_;
  std::unique_ptr<console::ConsoleReader> input_;
  Timer last_pause_, drops_, settled_;
};

}  // namespace

int run(const RunOptions& options) {
  open_missing_descriptors();
  island::keep_heap_small();
  std::signal(SIGPIPE, SIG_IGN);  // a closed standard output ends the session by an error of write()
  base::ConfigErrors errors;
  auto config = load_island(options.file, options.overrides, errors);
  if (!config) return report(config.error());
  if (!errors.empty()) return check({.file = options.file, .overrides = options.overrides, .elsewhere = true});
  auto tuples = island::read_own_tuples(options.tuples, config->proxy.prefix);
  if (!tuples) return report(tuples.error());
  config->tuples = std::move(*tuples);
  transport::Loop loop;
  program::SpdlogSink lines(options.log_level);
  const auto least = options.log_level == "debug" ? base::LogLevel::kDebug : base::LogLevel::kInfo;
  island::LogLines kept(lines, loop.scheduler(), least);
  Session session(options, loop, lines, kept);
  if (auto ready = session.prepare(std::move(*config)); !ready) return report(ready.error());
  session.run();
  program::end_within_seconds(session.exit_code());  // all is written
  return session.exit_code();
}

int list_networks() {
  for (const auto& type : island::network_types()) {
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

}  // namespace rubicon::daemon
