#include "networks/knx/knx_network.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

#include "model/findings.h"
#include "network/line_reports.h"
#include "networks/knx/bus_points.h"
#include "networks/knx/capture.h"
#include "networks/knx/knx_line.h"
#include "networks/knx/knx_options.h"
#include "networks/knx/knx_sample.h"
#include "networks/knx/problems.h"
#include "networks/knx/secure_access.h"
#include "networks/knx/tool_requests.h"
#include "networks/knx/wire/cemi.h"
#include "rubicon/key.hpp"
#include "transport/interfaces.h"

namespace rubicon::networks::knx {

namespace {

using namespace std::chrono_literals;

/// Lifetime of telegrams for exposed tuples: after a reconnect hundreds may wait.
constexpr Duration kExposedLifetime = 10min;

class KnxNetwork final : public network::Network {
 public:
  KnxNetwork(const network::NetworkConfig& config, KnxOptions options, network::NetworkHost& host)
      : options_(std::move(options)),
        configured_line_(options_.line),
        host_(host),
        types_(config.types),
        remembers_(config.remembers),
        log_(host.limited_log()),
        capture_(options_.capture),
        points_(host, {}, [this](const Problem& problem) { report(problem); }),
        exposures_(host, config.types,
                   [this](wire::Telegram telegram, auto done) { send_exposed(std::move(telegram), std::move(done)); },
                   {[this](const Problem& problem) { report(problem); },
                    [this](wire::GroupAddress address) { problems_.end(kNoSource, address); }}),
        tools_(
            host, capture_, [this](wire::GroupAddress address) { return meaning(address); },
            [this](wire::GroupAddress address) { return points_.table().command_at(address); },
            [this](const wire::Telegram& telegram) { points_.receive(telegram); }),
        reporter_(host, [this] { return state(); }) {
    points_.set_table(PointTable(options_.points, types_, options_.notation));
    options_.points = std::vector<groups::GroupPoint>();  // the table has them; `{}` would keep their memory
  }

  Result<void> open() override;
  Result<void> reopen() override;
  Result<void> send(const model::Message& message) override;
  Result<void> change(const network::NetworkConfig& config) override;
  std::optional<std::vector<network::ListedDevice>> listed() const override;
  std::vector<network::Missing> missing() const override;

 private:
  void make_line();
  Result<void> derive_keys();
  void use_keys(Result<SecureAccess> access);
  void try_next_tunnel(const line::LineState& state);
  void use_next_tunnel(Result<SecureAccess> access);
  void secure_groups(secure::GroupKeys keys);
  std::string read_only() const;
  secure::GroupStorage storage();
  void line_changed(const line::LineState& state);
  void line_lost(Error why);
  void line_down();
  void received(const wire::Telegram& telegram);
  void send_exposed(wire::Telegram telegram, std::function<void(bool sent, std::string_view refused)> done);
  std::pair<std::string, const dpt::Dpt*> name_and_type(wire::GroupAddress address) const;
  ToolRequests::Meaning meaning(wire::GroupAddress address) const;
  std::string show(wire::GroupAddress address) const { return to_string(address, options_.notation); }
  void show_sent(ByteView cemi);
  void warn(const std::string& subject, std::string_view text);
  void report(const Problem& problem);
  void warn_of_duplicate_address(const model::State& state);
  std::optional<model::State> state_without_keys() const;
  void add_counters(std::map<std::string, std::uint64_t>& all) const;
  void add_limits(model::State& state) const;
  std::optional<model::State> state();

  KnxOptions options_;
  const LineOptions configured_line_;  ///< without what the keys added
  network::NetworkHost& host_;
  const TypeCatalogue& types_;
  const bool remembers_;  ///< the island has a state file
  base::LimitedLog log_;
  Capture capture_;
  BusPoints points_;
  Exposures exposures_;
  ToolRequests tools_;
  network::StateReporter reporter_;
  UnassignedAddresses unassigned_;
  Problems problems_;
  Repetitions repetitions_;
  bool opened_ = false, up_ = false, warned_duplicate_address_ = false;
  std::unique_ptr<transport::Worker> worker_;  ///< while the keys of KNX Secure are derived
  Error refused_;                              ///< why there are no keys; the options are to be changed
  std::uint64_t key_attempts_ = 0;             ///< to derive the keys again, for a user
  /// What the keys do not permit, for the user: a line that is plain, groups that cannot be written or have no key.
  std::string missing_keys_, plain_;
  TunnelRound round_;
  bool has_group_keys_ = false;
  std::unique_ptr<secure::GroupGuard> guard_;
  std::unique_ptr<line::Line> line_;  ///< destroyed before what its callbacks use; nullptr until there are keys
  base::Lifetime lifetime_;
};

void KnxNetwork::make_line() {
  line::LineCallbacks calls;
  calls.changed = [this](const line::LineState& state) { line_changed(state); };
  calls.failed = [this](Error why) { line_lost(std::move(why)); };
  calls.received = [this](const wire::Telegram& telegram) { received(telegram); };
  calls.settled = [this] { reporter_.counters_changed(); };
  calls.frame = [this](ByteView cemi, bool outgoing) {
    if (outgoing) reporter_.counters_changed();
    capture_.add(cemi, outgoing, host_.scheduler().wall_now());
    if (!outgoing || !tools_.monitored()) return;
    show_sent(cemi);
  };
  calls.note = [this](const std::string& subject, std::string_view text) { warn(subject, text); };
  line_ = knx::make_line(options_.line, host_.scheduler(), host_.transports(), std::move(calls));
}

/// A telegram of ours, for monitors: of a secured group it is encrypted.
void KnxNetwork::show_sent(ByteView cemi) {
  const auto frame = wire::read_data_frame(cemi);
  if (!frame) return;
  if (!guard_) {
    if (const auto telegram = wire::to_telegram(*frame)) tools_.seen(*telegram, true);
  } else if (const auto peeked = guard_->peek(*frame)) {
    tools_.seen(peeked->telegram, true);
  }
}

/// Passwords become keys on a thread of their own, because each takes some 15 ms.
Result<void> KnxNetwork::derive_keys() {
  auto worker = host_.transports().start_worker("knx-keys");
  if (!worker) return fail(worker.error());
  worker_ = std::move(*worker);
  auto use = lifetime_.guard([this](Result<SecureAccess> access) {
    worker_.reset();
    line_ ? use_next_tunnel(std::move(access)) : use_keys(std::move(access));
  });
  worker_->run([secure = options_.secure, line = configured_line_, taken = round_.unusable(),
                &scheduler = host_.scheduler(), use] {
    auto access = std::make_shared<Result<SecureAccess>>(derive_access(secure, line, taken));
    scheduler.post([use, access]() mutable { use(std::move(*access)); });
  });
  reporter_.line_changed();
  return {};
}

/// The interface gave away the tunnel that the keyring chose, or refuses its user: the next one may be free.
void KnxNetwork::try_next_tunnel(const line::LineState& state) {
  const auto& tunnel = options_.line.tunnel;
  if (worker_ || !options_.secure.keyring || !tunnel.secure || !tunnel.wanted || configured_line_.tunnel.wanted) return;
  if (state.user_refused)
    warn("refused tunnels", fmt::format("the tunnel {} is skipped until the line is opened again: {}",
                                        to_string(*tunnel.wanted), state.reason));
  state.user_refused ? round_.user_refused(*tunnel.wanted) : round_.in_use(*tunnel.wanted);
  if (auto started = derive_keys(); !started) round_.up();
}

/// After the last tunnel of the keyring the line pauses, and all are tried again.
void KnxNetwork::use_next_tunnel(Result<SecureAccess> access) {
  if (access && access->session && access->tunnel) {
    options_.line.tunnel.wanted = access->tunnel;
    line_->use(std::move(*access->session), *access->tunnel);
  } else {
    const bool again = round_.end(line_->state().user_refused, access ? Error{} : access.error());
    if (auto started = again ? derive_keys() : Result<void>(); !started) round_.reopen();
  }
  reporter_.line_changed();
}

void KnxNetwork::use_keys(Result<SecureAccess> access) {
  if (!access && access.error().code == ErrorCode::kIo) return line_lost(access.error());  // no fault of the options
  if (!access) {
    refused_ = access.error();
    return reporter_.line_changed();
  }
  auto& line = options_.line;
  line.tunnel.secure = std::move(access->session);
  if (access->tunnel) line.tunnel.wanted = access->tunnel;
  line.gateways = std::move(access->gateways);
  line.routing.secure = std::move(access->routing);
  if (line.routing.secure) line.routing.storage = storage();
  if (!access->multicast.empty() && !line.multicast_given) line.routing.group.address = access->multicast;
  plain_ = std::move(access->plain);
  if (!plain_.empty()) host_.log().warning(plain_);
  secure_groups(std::move(access->groups));
  make_line();
  if (auto opened = line_->open(); !opened) line_lost(opened.error());
}

secure::GroupStorage KnxNetwork::storage() {
  using network::Keep;
  return {[this](std::string_view name, ByteView value) { return host_.remember(name, value, Keep::kNow); },
          [this](std::string_view name) { return host_.remembered(name); },
          [this](std::string_view name, ByteView value) { return host_.remember(name, value, Keep::kSoon); }};
}

/// Makes the guard of the groups with a key, and of those that are secured without one.
void KnxNetwork::secure_groups(secure::GroupKeys keys) {
  has_group_keys_ = !keys.groups.empty();
  missing_keys_ = explain_missing_keys(add_without_keys(keys, options_.secured), options_.secure);
  if (keys.groups.empty()) return;
  if (!missing_keys_.empty()) host_.log().warning(missing_keys_);
  const auto own = options_.line.via == Via::kRouting ? options_.line.routing.address
                                                      : options_.line.tunnel.wanted.value_or(wire::IndividualAddress{});
  guard_ = std::make_unique<secure::GroupGuard>(
      host_.scheduler(), std::move(keys), storage(), own,
      [this](std::string_view subject, std::string_view text) { warn(std::string(subject), text); });
  options_.line.tunnel.guard = options_.line.routing.guard = guard_.get();
  if (const auto text = read_only(); !text.empty()) host_.log().warning(text);
}

/// Why secured groups with a key cannot be written; empty if they can.
std::string KnxNetwork::read_only() const {
  if (!guard_ || !has_group_keys_) return {};
  const auto can = guard_->can_send();
  return can ? std::string() : fmt::format("secured groups can only be read: {}", can.error().text);
}

Result<void> KnxNetwork::open() {
  if (!std::exchange(opened_, true)) {
    if (!options_.report.empty()) host_.log().info(options_.report);
    if (points_.table().points().empty())
      host_.log().info(
          "no group addresses are configured: the property unassigned lists the addresses of received telegrams");
    points_.begin();
    exposures_.set(options_.exposures);
  }
  if (!line_ && options_.secure.any()) return worker_ || !refused_.text.empty() ? Result<void>() : derive_keys();
  if (!line_) {
    secure_groups({});
    make_line();
  }
  return line_->open();
}

Result<void> KnxNetwork::reopen() {
  round_.reopen();
  if (line_) return line_->reopen() ? Result<void>() : Network::reopen();
  if (refused_.text.empty()) return Network::reopen();
  if (auto started = derive_keys(); !started) return started;
  ++key_attempts_;
  refused_ = {};
  return {};
}

std::optional<std::vector<network::ListedDevice>> KnxNetwork::listed() const {
  std::vector<network::ListedDevice> all;
  for (const auto& [address, device] : points_.table().devices())
    all.push_back({address, points_.table().join_of(address).capabilities});
  return all;
}

std::vector<network::Missing> KnxNetwork::missing() const {
  std::vector<network::Missing> all;
  const auto& wanted = options_.line.routing.interface_address;
  const auto interfaces = transport::ipv4_interfaces();
  const auto is_wanted = [&wanted](const auto& interface) { return interface.address == wanted; };
  if (!wanted.empty() && std::none_of(interfaces.begin(), interfaces.end(), is_wanted))
    all.push_back({"interface", fmt::format("no interface of this host has the address {}", wanted)});
  add_missing_keys(options_.secure, options_.line, options_.secured, remembers_, all);
  return all;
}

void KnxNetwork::line_changed(const line::LineState& state) {
  if (state.phase == line::LineState::Phase::kUp && !std::exchange(up_, true)) {
    round_.up();
    tools_.use(line_.get());
    points_.line_up(*line_);
    exposures_.line_up();
  } else if (state.phase != line::LineState::Phase::kUp) {
    line_down();
  }
  if (state.tunnel_in_use || state.user_refused) try_next_tunnel(state);
  reporter_.line_changed();
}

void KnxNetwork::line_lost(Error why) {
  line_down();
  host_.failed(std::move(why));
}

void KnxNetwork::line_down() {
  if (!std::exchange(up_, false)) return;
  tools_.use(nullptr);
  points_.line_down();
  exposures_.line_down();
}

void KnxNetwork::received(const wire::Telegram& telegram) {
  if (repetitions_.contain(telegram, host_.scheduler().now())) return;
  tools_.seen(telegram, false);
  const bool exposed = telegram.service == wire::Service::kRead ? exposures_.answer(telegram)
                                                                : exposures_.contains(telegram.destination);
  if (!points_.receive(telegram) && !exposed) unassigned_.add(telegram, host_.scheduler().wall_now());
  reporter_.counters_changed();
}

void KnxNetwork::send_exposed(wire::Telegram telegram, std::function<void(bool, std::string_view)> done) {
  if (!line_) return done(false, {});
  line_->send(std::move(telegram), host_.scheduler().now() + kExposedLifetime,
              [done = std::move(done)](line::SendOutcome outcome, std::string_view why) {
                done(outcome == line::SendOutcome::kSent || outcome == line::SendOutcome::kUnconfirmed,
                     outcome == line::SendOutcome::kRefused ? why : std::string_view());
              });
}

/// The configured name and type of an address.
std::pair<std::string, const dpt::Dpt*> KnxNetwork::name_and_type(wire::GroupAddress address) const {
  const auto listeners = points_.table().listeners_of(address);
  if (!listeners.empty()) {
    const auto& point = points_.table().points()[listeners.front().point];
    const bool state = point.group.state == address && !point.group.state_name.empty();
    return {state ? point.group.state_name : point.group.name, point.dpt};
  }
  for (const auto& point : points_.table().points()) {
    if (point.group.address == address) return {point.group.name, point.dpt};
  }
  for (const auto& exposed : options_.exposures) {
    if (exposed.address == address) return {exposed.tuple, dpt::find_dpt(exposed.dpt)};
  }
  return {};
}

ToolRequests::Meaning KnxNetwork::meaning(wire::GroupAddress address) const {
  auto [name, type] = name_and_type(address);
  return {std::move(name), type, show(address), guard_ && guard_->secures(address)};
}

Result<void> KnxNetwork::send(const model::Message& message) {
  reporter_.counters_changed();
  const auto& device = message.destination.device;
  if (device.empty()) return tools_.receive(message);
  if (!points_.table().devices().contains(device))
    return fail(ErrorCode::kNotFound, fmt::format("no device {}", model::quoted(device)));
  if (const auto* command = std::get_if<model::Actuate>(&message.body)) return points_.actuate(device, *command);
  if (const auto* request = std::get_if<model::Sample>(&message.body)) return points_.sample(device, *request);
  return fail(ErrorCode::kUnsupported, fmt::format("KNX does not support {}", to_string(message.kind())));
}

Result<void> KnxNetwork::change(const network::NetworkConfig& config) {
  auto read = network::read_options<read_knx_options>(config, host_);
  if (!read) return fail(std::move(read.error()));
  KnxOptions next = std::move(*read);
  if (!same_access(next.secure, options_.secure) || next.secured != options_.secured ||
      !same_line(next.line, configured_line_))
    return fail(ErrorCode::kUnsupported, "the options of the line differ");
  PointTable table(std::exchange(next.points, {}), types_, next.notation);
  next.line = std::move(options_.line);  // with its keys
  options_ = std::move(next);
  capture_.set_limits(options_.capture);
  if (!options_.report.empty()) host_.log().info(options_.report);
  points_.set_table(std::move(table));
  if (opened_) exposures_.set(options_.exposures);
  unassigned_.remove_if(
      [this](wire::GroupAddress address) { return points_.table().contains(address) || exposures_.contains(address); });
  problems_.keep(
      [this](wire::GroupAddress address) { return points_.table().contains(address) || exposures_.contains(address); });
  reporter_.counters_changed();
  return {};
}

void KnxNetwork::warn(const std::string& subject, std::string_view text) {
  reporter_.counters_changed();
  log_.warning(subject, text);
}

void KnxNetwork::report(const Problem& problem) {
  problems_.add(problem, host_.scheduler().wall_now());
  reporter_.counters_changed();
  if (problem.what == kBadValue) return;  // the proxy logs the reason of a bad reading
  warn(fmt::format("{} {}", problem.what, show(problem.address)),
       fmt::format("{}: {}", show(problem.address), problem.reason));
}

void KnxNetwork::warn_of_duplicate_address(const model::State& state) {
  const auto duplicate = state.counters.find("doubled-address");
  if (duplicate == state.counters.end() || duplicate->second == 0) return;
  if (std::exchange(warned_duplicate_address_, true)) return;
  host_.log().warning(
      fmt::format("{} is also the address of another device on the bus", to_string(line_->state().own)));
}

std::optional<model::State> KnxNetwork::state_without_keys() const {
  const std::map<std::string, std::uint64_t> counters{{"attempts", key_attempts_}};
  if (worker_)
    return model::State{model::LineState::kConnecting, "derives the keys of KNX Secure from its passwords", counters};
  if (refused_.text.empty()) return std::nullopt;
  return model::State{model::LineState::kRefused, refused_.text, counters, {}, std::string(refused_.finding)};
}

void KnxNetwork::add_counters(std::map<std::string, std::uint64_t>& all) const {
  const auto& points = points_.counters();
  all.insert({{"readings", points.readings},
              {"undecodable-values", points.bad_values},
              {"commands", points.commands},
              {"failed-commands", points.failed_commands},
              {"reads", points_.reads().sent_count()},
              {"unanswered-reads", points_.reads().unanswered()},
              {"waiting-reads", points_.reads().waiting()},
              {"bus-repetitions", repetitions_.count()},
              {"exposed", exposures_.size()},
              {"exposed-without-value", exposures_.without_value()},
              {"refused-exposures", exposures_.refused()},
              {"unassigned-addresses", unassigned_.size()},
              {"dropped-unassigned", unassigned_.dropped()}});
}

void KnxNetwork::add_limits(model::State& state) const {
  namespace findings = model::findings;
  for (const auto& [text, finding] :
       {std::pair(plain_, findings::kPlainLine), std::pair(missing_keys_, findings::kGroupWithoutKey),
        std::pair(read_only(), findings::kGroupsReadOnly)}) {
    if (text.empty()) continue;
    state.reason += (state.reason.empty() ? "" : "; ") + text;
    if (state.finding.empty()) state.finding = finding;
  }
}

/// None while the line is lost: the supervisor then reports.
std::optional<model::State> KnxNetwork::state() {
  if (opened_ && !line_) return state_without_keys();
  if (!line_) return std::nullopt;
  const auto& line = line_->state();
  using Phase = line::LineState::Phase;
  if (!opened_ || line.phase == Phase::kOff) return std::nullopt;
  const bool refused = !worker_ && (line.phase == Phase::kWaiting || line.phase == Phase::kRefused);
  const bool round = line.tunnel_in_use && !round_.text().empty();
  model::State state{up_       ? model::LineState::kUp
                     : refused ? model::LineState::kRefused
                               : model::LineState::kConnecting,
                     round ? round_.text() : line.reason,
                     line_->counters(),
                     {},
                     std::string(round ? round_.finding() : line.finding)};
  state.counters["attempts"] += key_attempts_;
  warn_of_duplicate_address(state);
  add_counters(state.counters);
  if (up_) add_limits(state);
  state.texts = {{"unassigned", unassigned_.json(options_.notation)},
                 {"problems", problems_.json(options_.notation)},
                 {"server", line.server},
                 {"gateway", line.gateway},
                 {"tunnel-address", number(line.own) == 0 ? std::string() : to_string(line.own)},
                 {"bus", line.bus ? "ok" : "silent"}};
  return state;
}

}  // namespace

constexpr std::array<std::string_view, 8> kFileOptions{"import",
                                                       "import-password-file",
                                                       "keyring",
                                                       "keyring-password-file",
                                                       "user-password-file",
                                                       "device-password-file",
                                                       "backbone-key-file",
                                                       "group-keys-file"};

const network::NetworkType kType{
    .name = "knx",
    .summary = "a KNX installation, by a KNXnet/IP tunnel or by routing",
    .sample_config = kSample,
    .make = network::make_network<KnxNetwork, read_knx_options>,
    .lists_devices = true,
    .file_options = kFileOptions,
    .quiet = true,
};

}  // namespace rubicon::networks::knx
