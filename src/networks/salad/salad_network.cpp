#include "networks/salad/salad_network.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <set>
#include <tuple>
#include <utility>

#include "base/log.h"
#include "base/scheduler.h"
#include "network/line_reports.h"
#include "networks/salad/salad_line.h"
#include "networks/salad/salad_options.h"
#include "networks/salad/salad_sample.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::salad {

namespace {

using model::LineState;

constexpr std::string_view kNotYet = "no update from SALAD yet";
/// Log lines a minute about ids that are not configured; each id is logged once.
constexpr int kUnknownIdLines = 5;

class SaladNetwork final : public network::Network {
 public:
  SaladNetwork(const network::NetworkConfig& config, SaladOptions options, network::NetworkHost& host)
      : options_(std::move(options)),
        types_(config.types),
        host_(host),
        line_(options_, host.transports(),
              {.ready = [this] { ready(); },
               .failed = [this](Error why) { lost(std::move(why)); },
               .received = [this](ByteView bytes) { received(bytes); },
               .undelivered = [this](const Error& error) { undelivered(error); },
               .counted = [this] { reporter_.counters_changed(); }}),
        log_(host.limited_log()),
        silence_(host.scheduler(), [this] { request_again(); }),
        reporter_(host, [this] { return line_.ready() ? std::optional(state()) : std::nullopt; }) {}
  /// Asks SALAD to stop its updates (salad.md, section 2).
  ~SaladNetwork() override { static_cast<void>(line_.send(kStopUpdates)); }
  SaladNetwork(const SaladNetwork&) = delete;
  SaladNetwork& operator=(const SaladNetwork&) = delete;

  Result<void> open() override;
  Result<void> send(const Message& message) override;
  Result<void> change(const network::NetworkConfig& config) override;
  std::optional<std::vector<network::ListedDevice>> listed() const override;

 private:
  void ready();
  void lost(Error why);
  void start();
  void restart_silence();
  void request_again();
  void received(ByteView bytes);
  void undelivered(const Error& error);
  void deliver(const Item& item);
  void unknown_id(DeviceId id);
  void join(DeviceId id);
  Result<void> put(std::string_view datagram);
  Result<void> actuate(DeviceId id, const model::Actuate& command);
  void set_line(LineState state, std::string reason);
  model::State state();

  SaladOptions options_;
  const TypeCatalogue& types_;
  network::NetworkHost& host_;
  SaladLine line_;
  bool joined_ = false;
  bool started_ = false;  ///< updates were requested since the line became ready
  /// Up: SALAD sends updates. Connecting: they were requested, none came yet. Down: it cannot be reached.
  LineState line_state_ = LineState::kConnecting;
  std::string reason_{kNotYet};           ///< why it is not up
  std::uint64_t undelivered_before_ = 0;  ///< the last request for updates
  std::map<Fault, std::uint64_t> faults_;
  std::uint64_t readings_ = 0, starts_ = 0, commands_ = 0, unknown_ids_ = 0;
  std::set<DeviceId> logged_ids_;  ///< unknown ones
  base::LimitedLog log_;
  base::Deadline silence_;
  Timer send_failure_;
  network::StateReporter reporter_;
};

/// The devices join before any contact (salad.md, section 6: the original showed between 16 and 55 of 55).
Result<void> SaladNetwork::open() {
  if (!std::exchange(joined_, true)) {
    for (const auto& [id, device] : options_.devices) join(id);
    if (!options_.unknown_keys.empty())
      host_.log().warning(fmt::format("ignored unknown keys of the properties file: {}",
                                      model::quoted(fmt::format("{}", fmt::join(options_.unknown_keys, ", ")))));
  }
  return line_.open();
}

std::optional<std::vector<network::ListedDevice>> SaladNetwork::listed() const {
  std::vector<network::ListedDevice> all;
  for (const auto& [id, device] : options_.devices) all.push_back({std::to_string(id), join_of(device).capabilities});
  return all;
}

void SaladNetwork::join(DeviceId id) {
  host_.deliver(std::to_string(id), join_of(options_.devices.at(id)));
}

void SaladNetwork::ready() {
  if (!std::exchange(started_, true)) start();
  reporter_.line_changed();
}

void SaladNetwork::lost(Error why) {
  started_ = false;
  line_state_ = LineState::kConnecting;
  reason_ = kNotYet;
  silence_.clear();
  host_.failed(std::move(why));
}

void SaladNetwork::start() {
  ++starts_;
  undelivered_before_ = line_.counters().undelivered;
  if (auto sent = put(kStartUpdates); !sent) log_.warning("send", sent.error().text);
  restart_silence();
}

void SaladNetwork::restart_silence() {
  if (options_.start_again) {
    silence_.set(*options_.start_again);
  } else {
    silence_.clear();
  }
}

/// SALAD may have been restarted, or moved; a repeated request does no harm (salad.md, section 6).
void SaladNetwork::request_again() {
  if (!line_.ready()) return;
  if (line_state_ == LineState::kUp)
    set_line(LineState::kConnecting, "SALAD stopped sending updates; they were requested again");
  else if (line_state_ == LineState::kDown && line_.counters().undelivered == undelivered_before_)
    set_line(LineState::kConnecting, std::string(kNotYet));  // the request was not reported as undelivered
  line_.refresh();
  start();
  reporter_.counters_changed();
}

void SaladNetwork::received(ByteView bytes) {
  const auto datagram = read_datagram(bytes, options_.buffer);
  for (const auto& [fault, times] : datagram.faults) {
    faults_[fault] += times;
    log_.warning(std::string(to_string(fault)),
                 fmt::format("{}: {}", to_string(fault), model::quoted(base::as_text(bytes))));
  }
  if (!datagram.items.empty()) {
    restart_silence();
    set_line(LineState::kUp, {});
  }
  for (const Item& item : datagram.items) deliver(item);
  reporter_.counters_changed();
}

void SaladNetwork::deliver(const Item& item) {
  const auto found = options_.devices.find(item.id);
  if (found == options_.devices.end()) return unknown_id(item.id);
  ++readings_;
  const auto& device = found->second;
  host_.deliver(std::to_string(item.id), updates_of(device, *types_.find(device.type_id), item.value));
}

void SaladNetwork::unknown_id(DeviceId id) {
  ++unknown_ids_;
  if (logged_ids_.contains(id)) return;
  const auto subject = fmt::format("unknown id {}", id % kUnknownIdLines);
  if (log_.warning(subject, fmt::format("device {} is not configured, its readings are dropped", id)))
    logged_ids_.insert(id);
}

void SaladNetwork::undelivered(const Error& error) {
  log_.warning("undelivered", error.text);
  set_line(LineState::kDown, fmt::format("SALAD cannot be reached: {}", error.text));
  reporter_.counters_changed();
}

Result<void> SaladNetwork::send(const Message& message) {
  const auto& address = message.destination.device;
  const auto id = read_id(address);
  if (!id || std::to_string(*id) != address || !options_.devices.contains(*id))
    return fail(ErrorCode::kNotFound, fmt::format("no device {}", model::quoted(address)));
  if (const auto* command = std::get_if<model::Actuate>(&message.body)) return actuate(*id, *command);
  if (message.kind() == MessageKind::kSample)
    return fail(ErrorCode::kUnsupported, "SALAD decides itself when it sends updates");
  return fail(ErrorCode::kUnsupported, fmt::format("SALAD takes no {}", to_string(message.kind())));
}

/// Where the system cannot send to SALAD (no route, no address), nothing comes from there either: the line ends, in a
/// turn of its own, and the supervisor opens it again.
Result<void> SaladNetwork::put(std::string_view datagram) {
  auto sent = line_.send(datagram);
  if (!sent && sent.error().code == ErrorCode::kIo)
    send_failure_ = host_.scheduler().after(Duration(0), [this, why = sent.error()] { line_.give_up(why); });
  return sent;
}

Result<void> SaladNetwork::actuate(DeviceId id, const model::Actuate& command) {
  const auto& device = options_.devices.at(id);
  const auto value = command_of(device, *types_.find(device.type_id), command);
  if (!value) {
    log_.warning(fmt::format("refused {}", id),
                 fmt::format("command to device {} refused: {}", id, value.error().text));
    return fail(value.error());
  }
  reporter_.counters_changed();
  if (auto sent = put(salad::actuate(device.actuator, *value)); !sent) return sent;
  ++commands_;
  host_.deliver(std::to_string(id), model::Acknowledge{command.request, model::Outcome::kSent, {}});
  return {};
}

Result<void> SaladNetwork::change(const network::NetworkConfig& config) {
  auto read = network::read_options<read_salad_options>(config, host_);
  if (!read) return fail(std::move(read.error()));
  SaladOptions next = std::move(*read);
  const auto line_of = [](const SaladOptions& o) { return std::tie(o.host, o.port, o.own_port, o.buffer); };
  if (line_of(next) != line_of(options_)) return fail(ErrorCode::kUnsupported, "host, port or buffer changed");
  const bool types_known = std::all_of(next.devices.begin(), next.devices.end(), [this](const auto& device) {
    return types_.find(device.second.type_id) != nullptr;
  });
  if (!types_known) return fail(ErrorCode::kUnsupported, "a device has a new type");
  const auto before = std::exchange(options_, std::move(next));
  if (!joined_) return {};
  for (const auto& [id, device] : before.devices) {
    if (!options_.devices.contains(id))
      host_.deliver(std::to_string(id), model::Leave{"removed from the configuration"});
  }
  for (const auto& [id, device] : options_.devices) {
    const auto old = before.devices.find(id);
    if (old == before.devices.end() || !(old->second == device)) join(id);
    logged_ids_.erase(id);
  }
  if (line_.ready() && options_.start_again != before.start_again) start();
  return {};
}

void SaladNetwork::set_line(LineState state, std::string reason) {
  if (line_state_ == state && reason_ == reason) return;
  line_state_ = state;
  reason_ = std::move(reason);
  reporter_.line_changed();
}

model::State SaladNetwork::state() {
  model::State state{line_state_, reason_, {}};
  const auto& line = line_.counters();
  state.counters = {{"port", line_.own_port()},
                    {"datagrams", line.datagrams},
                    {"dropped-other-source", line.other_source},
                    {"undelivered-datagrams", line.undelivered},
                    {"unsent", line_.unsent()},
                    {"readings", readings_},
                    {"starts", starts_},
                    {"commands", commands_},
                    {"dropped-unknown-id", unknown_ids_}};
  for (std::size_t fault = 0; fault < kFaults; ++fault) {
    const auto kind = static_cast<Fault>(fault);
    state.counters[std::string(to_string(kind))] = faults_[kind];
  }
  return state;
}

}  // namespace

constexpr std::array<std::string_view, 1> kFileOptions{"properties"};

const network::NetworkType kType{
    .name = "salad",
    .summary = "the devices of the SALAD middleware, over UDP",
    .sample_config = kSample,
    .make = network::make_network<SaladNetwork, read_salad_options>,
    .lists_devices = true,
    .file_options = kFileOptions,
};

}  // namespace rubicon::networks::salad
