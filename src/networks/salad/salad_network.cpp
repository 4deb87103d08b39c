#include "networks/salad/salad_network.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>

#include "base/rate_limit.h"
#include "networks/salad/salad_line.h"
#include "networks/salad/salad_points.h"
#include "networks/salad/salad_sample.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::salad {

namespace {

using namespace std::chrono_literals;
using model::LineState;

constexpr Duration kCountersEvery = 1s;
constexpr std::string_view kNotYet = "no update of SALAD yet";
/// Lines a minute about ids that are not configured; each id is named once.
constexpr int kUnknownIdLines = 5;

class SaladNetwork final : public network::Network {
 public:
  SaladNetwork(const network::NetworkConfig& config, SaladOptions options, network::NetworkHost& host)
      : options_(std::move(options)),
        types_(config.types),
        host_(host),
        line_(options_, host.transports(),
              {[this] { ready(); }, [this](Error why) { lost(std::move(why)); },
               [this](ByteView bytes) { received(bytes); }, [this](const Error& error) { undelivered(error); },
               [this] { report_later(); }}) {}
  /// SALAD stops its updates (salad.md, section 2), if it hears it.
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
  void nothing_heard();
  void received(ByteView bytes);
  void undelivered(const Error& error);
  void deliver(const Item& item);
  void unknown_id(DeviceId id);
  void join(DeviceId id);
  Result<void> actuate(DeviceId id, const model::Actuate& command);
  void say(const std::string& kind, std::string_view text);
  void set_line(LineState state, std::string reason);
  void report();
  void report_later();

  SaladOptions options_;
  const TypeCatalogue& types_;
  network::NetworkHost& host_;
  SaladLine line_;
  bool joined_ = false;
  bool started_ = false;  ///< asked for updates since the line came up
  /// Up = SALAD speaks. Connecting = it was asked for updates and has not answered. Down = it is not there.
  LineState state_ = LineState::kConnecting;
  std::string reason_{kNotYet};           ///< why it is not up
  std::uint64_t undelivered_before_ = 0;  ///< when it was last asked
  std::map<Fault, std::uint64_t> faults_;
  std::uint64_t readings_ = 0, starts_ = 0, commands_ = 0, unknown_ids_ = 0;
  std::set<DeviceId> named_;  ///< unknown ids that were logged
  base::RateLimit limit_;
  SteadyTime heard_{};
  Timer silence_, counters_;
};

/// The devices are there before any contact (salad.md, section 6: of 55 the original showed between 16 and 55).
Result<void> SaladNetwork::open() {
  if (!std::exchange(joined_, true)) {
    for (const auto& [id, device] : options_.devices) join(id);
    if (!options_.unknown_keys.empty())
      host_.log().warning(fmt::format("the properties file has keys nobody reads: {}",
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
  report();
}

void SaladNetwork::lost(Error why) {
  started_ = false;
  state_ = LineState::kConnecting;
  reason_ = kNotYet;
  silence_.cancel();
  host_.failed(std::move(why));
}

void SaladNetwork::start() {
  ++starts_;
  undelivered_before_ = line_.counters().undelivered;
  if (auto sent = line_.send(kStartUpdates); !sent) say("send", sent.error().text);
  heard_ = host_.scheduler().now();
  silence_.cancel();
  if (options_.start_again) silence_ = host_.scheduler().after(*options_.start_again, [this] { nothing_heard(); });
}

/// SALAD may have been restarted, or moved: asking again is harmless (salad.md, section 6).
void SaladNetwork::nothing_heard() {
  if (!line_.ready() || !options_.start_again) return;
  const auto due = heard_ + *options_.start_again;
  if (due > host_.scheduler().now()) {
    silence_ = host_.scheduler().at(due, [this] { nothing_heard(); });
    return;
  }
  if (state_ == LineState::kUp)
    set_line(LineState::kConnecting, "no update of SALAD any more: it was asked again");
  else if (state_ == LineState::kDown && line_.counters().undelivered == undelivered_before_)
    set_line(LineState::kConnecting, std::string(kNotYet));  // its host takes what we send
  line_.refresh();
  start();
  report_later();
}

void SaladNetwork::received(ByteView bytes) {
  const auto datagram = read_datagram(bytes, options_.buffer);
  for (const auto& [fault, times] : datagram.faults) {
    faults_[fault] += times;
    say(std::string(to_string(fault)), fmt::format("{}: {}", to_string(fault), model::quoted(base::as_text(bytes))));
  }
  if (!datagram.items.empty()) {
    heard_ = host_.scheduler().now();
    set_line(LineState::kUp, {});
  }
  for (const Item& item : datagram.items) deliver(item);
  report_later();
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
  if (named_.contains(id)) return;
  if (!limit_.allow(fmt::format("unknown id {}", id % kUnknownIdLines), host_.scheduler().now())) return;
  named_.insert(id);
  host_.log().warning(fmt::format("device {} is not configured, its readings are dropped", id));
}

void SaladNetwork::undelivered(const Error& error) {
  say("undelivered", error.text);
  set_line(LineState::kDown, fmt::format("SALAD is not there: {}", error.text));
  report_later();
}

Result<void> SaladNetwork::send(const Message& message) {
  const auto& address = message.destination.device;
  const auto id = read_id(address);
  if (!id || std::to_string(*id) != address || !options_.devices.contains(*id))
    return fail(ErrorCode::kNotFound, fmt::format("no device {}", model::quoted(address)));
  if (const auto* command = std::get_if<model::Actuate>(&message.body)) return actuate(*id, *command);
  if (message.kind() == MessageKind::kSample)
    return fail(ErrorCode::kUnsupported, "SALAD sends its updates when it likes to");
  return fail(ErrorCode::kUnsupported, fmt::format("SALAD takes no {}", to_string(message.kind())));
}

Result<void> SaladNetwork::actuate(DeviceId id, const model::Actuate& command) {
  const auto& device = options_.devices.at(id);
  const auto value = command_of(device, *types_.find(device.type_id), command);
  if (!value) {
    say(fmt::format("refused {}", id), fmt::format("command to device {} refused: {}", id, value.error().text));
    return fail(value.error());
  }
  report_later();
  if (auto sent = line_.send(salad::actuate(device.actuator, *value)); !sent) return sent;
  ++commands_;
  host_.deliver(std::to_string(id), model::Acknowledge{command.request, model::Outcome::kSent, {}});
  return {};
}

Result<void> SaladNetwork::change(const network::NetworkConfig& config) {
  auto read = network::read_options<read_salad_options>(config, host_);
  if (!read) return fail(std::move(read.error()));
  SaladOptions next = std::move(*read);
  const auto line_of = [](const SaladOptions& o) { return std::tie(o.host, o.port, o.own_port, o.buffer); };
  if (line_of(next) != line_of(options_)) return fail(ErrorCode::kUnsupported, "the line changes");
  const bool types_known = std::all_of(next.devices.begin(), next.devices.end(), [this](const auto& device) {
    return types_.find(device.second.type_id) != nullptr;
  });
  if (!types_known) return fail(ErrorCode::kUnsupported, "a type is new");
  const auto before = std::exchange(options_, std::move(next));
  if (!joined_) return {};
  for (const auto& [id, device] : before.devices) {
    if (!options_.devices.contains(id))
      host_.deliver(std::to_string(id), model::Leave{"taken out of the configuration"});
  }
  for (const auto& [id, device] : options_.devices) {
    const auto old = before.devices.find(id);
    if (old == before.devices.end() || !(old->second == device)) join(id);
    named_.erase(id);
  }
  if (line_.ready() && options_.start_again != before.start_again) start();
  return {};
}

/// At most one line a minute and kind; the counters have all.
void SaladNetwork::say(const std::string& kind, std::string_view text) {
  if (limit_.allow(kind, host_.scheduler().now())) host_.log().warning(text);
}

void SaladNetwork::set_line(LineState state, std::string reason) {
  if (state_ == state && reason_ == reason) return;
  state_ = state;
  reason_ = std::move(reason);
  if (line_.ready()) report();
}

void SaladNetwork::report_later() {
  if (counters_.pending() || !line_.ready()) return;
  counters_ = host_.scheduler().after(kCountersEvery, [this] {
    if (line_.ready()) report();
  });
}

void SaladNetwork::report() {
  model::State state{state_, reason_, {}};
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
  host_.deliver("", std::move(state));
}

}  // namespace

const network::NetworkType kType{
    .name = "salad",
    .summary = "the devices of the SALAD middleware, over UDP",
    .sample_config = kSample,
    .make = network::make_network<SaladNetwork, read_salad_options>,
    .lists_devices = true,
    .file_option = "properties",
};

}  // namespace rubicon::networks::salad
