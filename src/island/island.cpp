#include "island/island.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "config/yaml.h"
#include "island/alerts.h"
#include "island/config_checks.h"
#include "island/island_commands.h"
#include "island/island_state.h"
#include "island/island_tuples.h"
#include "island/overview.h"
#include "island/reload_plan.h"
#include "island/rights_checks.h"
#include "model/point_keys.h"
#include "model/type_names.h"
#include "proxy/proxy.h"
#include "transport/host_names.h"
#include "tuples/peer_policy.h"

namespace rubicon::island {

namespace {

island::IslandConfig with_host(island::IslandConfig config) {
  config.proxy.host = transport::host_name();
  return config;
}

}  // namespace

/// Members are declared in the order of construction: each uses only those above it.
struct Island::Impl {
  Impl(island::IslandConfig some_config, std::unique_ptr<tuples::Link> ecology_link, Scheduler& scheduler,
       transport::Transports& some_transports, base::LogSink& sink, std::unique_ptr<state::StateStore> store)
      : config(with_host(std::move(some_config))),
        transports(some_transports),
        log(sink),
        state(std::move(store)),
        link(std::move(ecology_link)),
        space(config.id, scheduler, *link),
        own_tuples(space, config.tuples),
        recorders({scheduler, space, some_transports, sink, config.proxy.prefix}, config.proxy),
        gateway(scheduler, space, sink, config.limits),
        proxy(config.proxy, scheduler, space, gateway, config.types, sink, state.get()),
        memory(state.get()),
        networks(config.id, scheduler, some_transports, sink, gateway),
        settings({scheduler, space, config.proxy}),
        controls({scheduler, space, config.proxy}, networks),
        free_space(scheduler),
        metrics(scheduler, space, config.proxy.prefix),
        alerts(scheduler, space, config.proxy.prefix),
        overview(space, config.proxy.prefix, state.get()),
        presence(scheduler, space, config.proxy.island_name, config.proxy.prefix,
                 [this] { return proxy.device_counts(); }) {
    gateway.connect(networks);
    networks.provide_tuples([this](std::string_view tuple, std::function<void(std::string_view)> call) {
      return watch_tuple(tuple, std::move(call));
    });
    networks.provide_memory(memory);
    watch_numbers();
    watch_disks();
    watch_troubles(scheduler);
  }
  void watch_numbers();
  void watch_disks();
  void watch_troubles(Scheduler& scheduler);
  Result<network::TupleWatch> watch_tuple(std::string_view tuple, std::function<void(std::string_view)> call);

  Result<void> add(const island::NetworkSetup& setup, network::Supervisor& to, const std::string& directory,
                   std::size_t most_devices, base::ConfigErrors& errors);
  void add_what_files_changed(const island::IslandConfig& next, island::ReloadPlan& plan);
  void note_file(const island::NetworkSetup& setup);
  Result<void> try_options(const island::IslandConfig& next, island::ReloadPlan& plan, Scheduler& scheduler,
                           base::ConfigErrors& errors);
  void warn_of_lost_names(const island::IslandConfig& next, const network::Supervisor& trial, island::ReloadPlan& plan);
  void apply(island::IslandConfig next, island::ReloadPlan& plan);
  void take_rights(std::optional<config::RightsSetup> next);

  island::IslandConfig config;
  transport::Transports& transports;
  base::LogSink& log;
  std::unique_ptr<state::StateStore> state;
  std::unique_ptr<tuples::Link> link;
  TupleSpace space;
  island::OwnTuples own_tuples;
  Recorders recorders;  ///< ends after the networks: their last messages are recorded
  gateway::Gateway gateway;
  proxy::Proxy proxy;
  NetworkMemory memory;
  network::Supervisor networks;
  SettingsTuples settings;
  NetworkControls controls;
  std::unique_ptr<LogTuples> log_tuples;
  std::shared_ptr<rights::RightsJudge> judge;
  FreeSpace free_space;
  IslandMetrics metrics;
  Alerts alerts;
  Overview overview;
  IslandPresence presence;
  std::map<std::string, FileDigests> file_digests;  ///< of what options name, by network id
};

/// Publishes the free space of the disks that the island writes to, so that users see in time that one fills up.
void Island::Impl::watch_disks() {
  metrics.add([this](const IslandMetrics::Publish& publish) {
    const auto tell = [&](const std::string& name, const std::string& path) {
      if (const auto free = free_space.beside(path)) publish(name + "-free-bytes", *free);
    };
    if (state) tell("state", state_path(config));
    recorders.each([&](const std::string& name, const std::string& path) { tell("recorder-" + name, path); });
  });
}

/// The island itself first, then its networks and devices.
void Island::Impl::watch_troubles(Scheduler& scheduler) {
  alerts.add([this, &scheduler, failures = StateFailures()](model::AlertList& list) mutable {
    const model::IslandKey island{config.proxy.prefix};
    add_clock(island.text, scheduler.wall_now(), list);
    if (state) {
      add_disk(island.text + ".state", {"the state file", free_space.beside(state_path(config))}, list);
      failures.look(state->stats().failures, scheduler.now());
      failures.add(island.text + ".state", scheduler.now() - 2 * config.proxy.save_period, list);
    }
    recorders.each([&](const std::string& name, const std::string& path) {
      add_disk(island.recorder(name).text, {"the recorder " + name, free_space.beside(path)}, list);
    });
    for (const auto& key : {island.history(), island.recorder("*")}) {
      space.list({space.self(), key.status()}, [&](const TupleView& tuple) {
        add_unwritten(std::string(model::parent_key(tuple.key)), tuple.value, list);
      });
    }
    space.list({space.self(), island.bridge("*").status()}, [&](const TupleView& tuple) {
      add_bridge(std::string(model::parent_key(tuple.key)), tuple.value, list);
    });
    const auto interfaces = island.property("dds-interfaces");
    if (const auto seen = space.get(space.self(), interfaces))
      add_interfaces(std::string(model::parent_key(interfaces)), seen->value, list);
    add_held_back(island.text, config.engine.held_back, list);
  });
  alerts.add([this](model::AlertList& list) { proxy.add_alerts(list); });
}

void Island::Impl::watch_numbers() {
  metrics.add([this](const IslandMetrics::Publish& publish) {
    const auto messages = gateway.counters();
    publish("gateway-delivered", messages.delivered);
    publish("gateway-dropped-readings", messages.dropped_readings);
    publish("gateway-refused-busy", messages.refused_busy);
    publish("gateway-undeliverable", messages.undeliverable);
    publish("gateway-duplicates", messages.duplicates);
    publish("gateway-looped", messages.looped);
    publish("gateway-malformed", messages.malformed);
    publish("gateway-forged", messages.forged);
    publish("gateway-not-permitted", messages.not_permitted);
    const auto tuples = space.stats();
    publish("tuples-cached", tuples.cached);
    publish("tuples-subscriptions", tuples.subscriptions);
    publish("tuples-queued", tuples.queued);
    publish("tuples-merged", tuples.merged);
    publish("tuples-dropped", tuples.dropped);
    publish("tuples-refused", tuples.refused);
    link->each_counter([&](std::string_view name, std::uint64_t value) {
      if (value > 0) publish(std::string(name), value);
    });
    const auto devices = proxy.inbox_counters();
    publish("inbox-waiting", devices.pending);
    publish("inbox-ignored", devices.ignored);
    publish("inbox-refused", devices.refused);
    publish("inbox-unheard-messages", devices.discarded);
    recorders.publish_counters(publish);
    recorders.show();
    if (const auto& why = config.engine.held_back; !why.empty()) publish.word("dds-held-back", why);
  });
  if (!state) return;
  metrics.add([this](const IslandMetrics::Publish& publish) {
    const auto file = state->stats();
    publish("state-devices", file.devices);
    publish("state-bytes", file.bytes);
    publish("state-failures", file.failures);
    publish("state-pruned", file.pruned);
    publish("state-damaged", file.damaged);
  });
}

/// The subscription is active: a network that shows a value needs the device to report it.
Result<network::TupleWatch> Island::Impl::watch_tuple(std::string_view tuple,
                                                      std::function<void(std::string_view)> call) {
  auto pattern = Pattern::parse(model::current_key(tuple));
  if (!pattern) return fail(pattern.error());
  if (!pattern->exact()) return fail(ErrorCode::kInvalid, fmt::format("'{}' is a pattern, expected one tuple", tuple));
  if (!pattern->owner) pattern->owner = config.id;
  auto handle = space.subscribe(*pattern, {}, [call = std::move(call)](const tuples::Event& event) {
    call(event.kind == tuples::EventKind::kSet ? event.tuple.value : std::string_view());
  });
  return std::make_shared<tuples::Handle>(std::move(handle));
}

Island::Island(std::unique_ptr<Impl> impl, Scheduler& scheduler) : impl_(std::move(impl)), scheduler_(scheduler) {}
Island::~Island() = default;

/// Reads the options of the network and creates it; errors in the options are added to `errors`.
Result<void> Island::Impl::add(const island::NetworkSetup& setup, network::Supervisor& to, const std::string& directory,
                               std::size_t most_devices, base::ConfigErrors& errors) {
  ConfigReader options(setup.options, "networks." + setup.key, errors);
  const auto before = errors.lines().size();
  auto added = to.add(*setup.type, {setup.id, config.id, options, config.types, directory, config::parse_yaml,
                                    most_devices, !config.state.file.empty(), config.engine.closed});
  if (!added && errors.lines().size() == before) options.error("", added.error().text);
  options.also_known(island::kCommonNetworkKeys);
  options.finish();
  return added;
}

Result<std::unique_ptr<Island>> Island::make(island::IslandConfig config, Scheduler& scheduler,
                                             transport::Transports& transports, base::LogSink& log,
                                             tuples::Ecology& ecology, base::ConfigErrors& errors,
                                             std::unique_ptr<state::StateStore> state) {
  auto link = ecology.join(config.id);
  if (!link) return fail(link.error());
  auto impl = std::make_unique<Impl>(std::move(config), std::move(*link), scheduler, transports, log, std::move(state));
  for (auto& setup : impl->config.networks) {
    if (!setup.type) continue;
    std::ignore = impl->add(setup, impl->networks, impl->config.directory, impl->config.limits.devices, errors);
    impl->note_file(setup);
    setup.release_options();
  }
  if (!errors.empty()) return fail(ErrorCode::kInvalid, errors.text());
  return std::unique_ptr<Island>(new Island(std::move(impl), scheduler));
}

void Island::show_log(LogLines& lines) {
  impl_->log_tuples = std::make_unique<LogTuples>(scheduler_, impl_->space,
                                                  model::IslandKey{impl_->config.proxy.prefix}.log_lines(), lines);
}

void Island::judge_by(std::shared_ptr<rights::RightsJudge> judge, base::LogSink& commands) {
  impl_->proxy.log_commands_to(commands);
  impl_->judge = std::move(judge);
  impl_->metrics.add(
      [judge = impl_->judge](const IslandMetrics::Publish& publish) { publish("rights-refused", judge->refused()); });
}

void Island::show_word(std::string name, std::function<std::string()> text) {
  impl_->metrics.add([name = std::move(name), text = std::move(text)](const IslandMetrics::Publish& publish) {
    if (auto now = text(); !now.empty()) publish.word(name, std::move(now));
  });
}

void Island::start() {
  impl_->own_tuples.start();
  impl_->settings.start();
  impl_->settings.show_text(std::exchange(impl_->config.shown, {}));
  impl_->config.device_places.clear();
  impl_->recorders.take(impl_->config.recorders, impl_->config.directory);
  impl_->proxy.restore();
  impl_->controls.refresh();
  impl_->networks.start();
  impl_->metrics.start();
  impl_->alerts.start();
  impl_->presence.start();
}

void Island::close(std::function<void()> closed) {
  impl_->networks.close(std::move(closed));
}

namespace {

/// Discards the messages of networks that are created only to check their options.
struct NullSink final : network::MessageSink {
  void from_network(const std::string&, Message&&) override {}
};

const island::NetworkSetup& setup_of(const island::IslandConfig& config, const std::string& id) {
  return *std::find_if(config.networks.begin(), config.networks.end(), [&](const auto& one) { return one.id == id; });
}

/// What the files of the new and the changed networks show to be wrong, such as the password of a KNX keyring. Some 50
/// ms for each keyring that changed, in the turn of the reload.
Result<void> try_files(const island::IslandConfig& next, const network::Supervisor& trial) {
  for (const auto& setup : next.networks) {
    const auto* network = trial.find(setup.id);
    if (network == nullptr) continue;
    for (const auto& one : network->missing()) {
      if (one.kind == network::Missing::Kind::kWrong)
        return fail(ErrorCode::kInvalid, fmt::format("networks.{}.{}: {}", setup.key, one.option, one.text));
    }
  }
  return {};
}

}  // namespace

/// Warns of configured names that match no device: by the list of the network where there is one (the network created
/// for the check before the running one), else by the devices that the proxy lists.
void Island::Impl::warn_of_lost_names(const island::IslandConfig& next, const network::Supervisor& trial,
                                      island::ReloadPlan& plan) {
  for (const auto& setup : next.networks) {
    const auto& rules = next.proxy.networks.at(setup.id);
    if (rules.devices.empty()) continue;
    const auto* tried = trial.find(setup.id);
    const auto* network = tried ? tried : networks.find(setup.id);
    const auto listed = network ? network->listed() : std::nullopt;
    for (const auto& lost : lost_names(rules, listed, config.types))
      plan.warnings.push_back(
          fmt::format("networks.{}.devices.{}: {}", setup.key, fmt::join(lost.path, "."), lost.text));
    if (listed) continue;
    for (auto& line : proxy.lost_names(setup.id, rules)) plan.warnings.push_back(std::move(line));
  }
}

/// Creates the new and the changed networks once to check their options; opens nothing.
Result<void> Island::Impl::try_options(const island::IslandConfig& next, island::ReloadPlan& plan, Scheduler& scheduler,
                                       base::ConfigErrors& errors) {
  NullSink sink;
  base::NullLogSink log_sink;
  network::Supervisor trial(config.id, scheduler, transports, log_sink, sink);
  for (const auto* ids : {&plan.added, &plan.changed, &plan.retyped}) {
    for (const auto& id : *ids)
      std::ignore = add(setup_of(next, id), trial, next.directory, next.limits.devices, errors);
  }
  if (!errors.empty()) return fail(ErrorCode::kInvalid, errors.text());
  if (auto good = try_files(next, trial); !good) return good;
  warn_of_lost_names(next, trial, plan);
  return {};
}

void Island::Impl::note_file(const island::NetworkSetup& setup) {
  file_digests[setup.id] = digests_of_options_files(setup, config.directory, transports);
}

/// Adds to the plan the networks whose options name a file that changed, and those that an earlier reload failed to
/// create.
void Island::Impl::add_what_files_changed(const island::IslandConfig& next, island::ReloadPlan& plan) {
  const auto running = networks.ids();
  const auto has = [](const std::vector<std::string>& ids, const std::string& id) {
    return std::find(ids.begin(), ids.end(), id) != ids.end();
  };
  for (const auto& setup : next.networks) {
    if (has(plan.added, setup.id) || has(plan.changed, setup.id) || has(plan.retyped, setup.id)) continue;
    if (!has(running, setup.id)) {
      plan.added.push_back(setup.id);
      plan.lines.push_back(fmt::format("network {}: is added, an earlier attempt failed", setup.id));
    } else if (const auto files =
                   changed_files(file_digests[setup.id], digests_of_options_files(setup, next.directory, transports));
               !files.empty()) {
      plan.changed.push_back(setup.id);
      plan.lines.push_back(fmt::format("network {}: its {} changed", setup.id, fmt::join(files, ", ")));
    }
  }
}

namespace {

/// With the place of the device in the file.
std::string line_of(const proxy::Objection& objection, const island::IslandConfig& next) {
  const auto network = next.device_places.find(objection.network);
  if (network == next.device_places.end()) return objection.text;
  const auto device = network->second.find(objection.address);
  return device == network->second.end() ? objection.text
                                         : fmt::format("{}: {}", to_string(device->second), objection.text);
}

}  // namespace

Result<island::ReloadPlan> Island::plan(const island::IslandConfig& next, base::ConfigErrors& errors) {
  auto plan = island::plan_reload(impl_->config, next);
  if (!impl_->judge && impl_->config.rights != next.rights)
    plan.refusals.push_back("rights: this island started without them; restart it to begin");
  for (const auto& objection : impl_->proxy.objections(next.proxy)) plan.refusals.push_back(line_of(objection, next));
  if (!plan.refusals.empty()) return fail(ErrorCode::kRefused, fmt::format("{}", fmt::join(plan.refusals, "\n")));
  impl_->add_what_files_changed(next, plan);
  if (auto good = impl_->try_options(next, plan, scheduler_, errors); !good) return fail(std::move(good.error()));
  return plan;
}

Result<island::ReloadPlan> Island::reload(island::IslandConfig next, base::ConfigErrors& errors) {
  auto planned = plan(next, errors);
  if (planned) impl_->apply(std::move(next), *planned);
  return planned;
}

void Island::Impl::take_rights(std::optional<config::RightsSetup> next) {
  const bool same = config.rights == next;
  config.rights = std::move(next);
  if (!judge) return;
  judge->replace(rights_of(config));
  if (!same) tuples::SpaceRights::rejudge(space);
}

void Island::Impl::apply(island::IslandConfig next, island::ReloadPlan& plan) {
  base::ConfigErrors errors;  // stays empty: plan() read the same options without errors
  const auto remove = [this](const std::string& id) {
    networks.remove(id);
    gateway.forget(id);
  };
  std::vector<std::string> recreated = plan.retyped;
  for (const auto& id : plan.changed) {
    const auto& setup = setup_of(next, id);
    ConfigReader options(setup.options, "networks." + setup.key, errors);
    const auto changed = networks.change({id, config.id, options, config.types, next.directory, config::parse_yaml,
                                          next.limits.devices, !config.state.file.empty(), config.engine.closed});
    if (!changed) recreated.push_back(id);
  }
  for (const auto& id : plan.removed) remove(id);
  for (const auto& id : recreated) remove(id);
  settings.show_text(next.shown);
  gateway.limit(next.limits);
  config.directory = next.directory;
  config.limits = next.limits;
  next.proxy.host = config.proxy.host;
  config.proxy = next.proxy;
  config.networks = std::move(next.networks);
  config.recorders = std::move(next.recorders);
  config.bridges = std::move(next.bridges);
  config.history = std::move(next.history);
  config.web = std::move(next.web);
  config.audit = std::move(next.audit);
  take_rights(std::move(next.rights));
  recorders.take(config.recorders, config.directory);
  proxy.reconfigure(config.proxy);
  for (const auto& id : recreated) proxy.restart(id);
  for (const auto* ids : {&std::as_const(plan.added), &std::as_const(recreated)}) {
    for (const auto& id : *ids) {
      const auto added = add(setup_of(config, id), networks, config.directory, config.limits.devices, errors);
      if (!added) plan.lines.push_back(fmt::format("network {}: could not be created: {}", id, added.error().text));
    }
  }
  controls.refresh();
  for (auto& setup : config.networks) {
    note_file(setup);
    setup.release_options();
  }
}

SettingsTuples& Island::settings() {
  return impl_->settings;
}
TupleSpace& Island::space() {
  return impl_->space;
}
gateway::Gateway& Island::gateway() {
  return impl_->gateway;
}
network::Supervisor& Island::networks() {
  return impl_->networks;
}
const island::IslandConfig& Island::config() const {
  return impl_->config;
}

}  // namespace rubicon::island
