#include "networks/zigbee/zigbee_network.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "model/json_members.h"
#include "network/line_reports.h"
#include "networks/zigbee/arrivals.h"
#include "networks/zigbee/broker_line.h"
#include "networks/zigbee/device_table.h"
#include "networks/zigbee/tool_requests.h"
#include "networks/zigbee/zigbee_options.h"
#include "networks/zigbee/zigbee_sample.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::zigbee {

namespace {

using namespace std::chrono_literals;
using bridge::Topics;
using model::LineState;

/// How long the list of devices may take when the line is up: bridge/state arrives before it, and it may have
/// megabytes.
constexpr Duration kListTime = 5s;

/// How long all devices may be silent on a line that is up: where answers or availability are due, and where all
/// devices report only by themselves. Looked at each kSilence.
constexpr Duration kSilence = 1min, kLongSilence = 1h;
constexpr std::size_t kMaxRefused = 100;  // filters, and topics, that the broker refuses and a reason names

class ZigbeeNetwork final : public network::Network {
 public:
  ZigbeeNetwork(const network::NetworkConfig& config, ZigbeeOptions options, network::NetworkHost& host);

  Result<void> open() override;
  Result<void> reopen() override;
  Result<void> send(const Message& message) override;
  Result<void> change(const network::NetworkConfig& config) override;
  std::vector<network::Missing> missing() const override;

 private:
  BrokerLine::Callbacks line_calls();
  void connected();
  void lost(Error why);
  void too_long(std::string_view topic, std::size_t bytes);
  void forbidden(std::string_view filter, const Error& why);
  void unsubscribed(std::string_view filter);
  void not_taken(std::string_view topic, const Error& why);
  void received(const transport::MqttMessage& message);
  void from_bridge(const Topics::Found& found, const transport::MqttMessage& message);
  void info(std::string_view payload);
  void passed(std::string_view topic, std::string_view payload, bool outgoing);
  void event(std::string_view payload);
  void response(std::string_view what, std::string_view payload);
  void bridge_changed();
  void await_list();
  void await_states();
  std::size_t silent_devices() const;
  std::string trouble() const;
  std::string unusable() const;
  void unreadable(const transport::MqttMessage& message, const Error& why);
  std::optional<model::State> state() const;
  void add_counters(std::map<std::string, std::uint64_t>& counters) const;

  ZigbeeOptions options_;
  network::NetworkHost& host_;
  base::LimitedLog log_;
  network::StateReporter reporter_;
  Topics topics_;
  BridgeState bridge_;
  Arrivals arrivals_;
  ToolRequests tools_;
  bool opened_ = false;
  bool lost_ = false;  ///< the supervisor reports why
  bool up_ = false;    ///< as sent to the devices
  bool list_is_late_ = false;
  Timer list_patience_, silence_;
  SteadyTime up_since_{};
  std::set<std::string> forbidden_, not_taken_;  ///< filters, topics
  std::optional<std::size_t> too_long_list_;     ///< bytes of a list that was dropped
  std::uint64_t unreadable_ = 0, events_ = 0;
  DeviceTable devices_;
  BrokerLine line_;  ///< last: destroyed first, because its callbacks use all others
};

ZigbeeNetwork::ZigbeeNetwork(const network::NetworkConfig& config, ZigbeeOptions options, network::NetworkHost& host)
    : options_(std::move(options)),
      host_(host),
      log_(host.limited_log()),
      reporter_(host, [this] { return state(); }),
      topics_(options_.base),
      bridge_(host.scheduler(), options_.base, [this] { bridge_changed(); }),
      arrivals_(host.scheduler(),
                {.take = [this](const transport::MqttMessage& message) { devices_.received(message); },
                 .replaceable = [this](const transport::MqttMessage& message) { return devices_.repeats(message); }}),
      tools_(
          host, fmt::format("{}-{}", model::number(config.island), config.id), devices_,
          [this](std::string_view what, std::string payload) {
            return line_.publish(topics_.request(what), std::move(payload));
          },
          [this] { return trouble(); }),
      devices_(host, config.types, options_, topics_, line_, [this] { reporter_.counters_changed(); }),
      line_(host, options_.broker, line_calls()) {}

BrokerLine::Callbacks ZigbeeNetwork::line_calls() {
  return {.connected = [this] { connected(); },
          .received = [this](const transport::MqttMessage& message) { received(message); },
          .published = [this](std::string_view topic, std::string_view payload) { passed(topic, payload, true); },
          .too_long = [this](std::string_view topic, std::size_t bytes) { too_long(topic, bytes); },
          .forbidden = [this](std::string_view filter, const Error& why) { forbidden(filter, why); },
          .unsubscribed = [this](std::string_view filter) { unsubscribed(filter); },
          .taken = [this](std::string_view topic) { devices_.taken(topic); },
          .not_taken = [this](std::string_view topic, const Error& why) { not_taken(topic, why); },
          .lost = [this](Error why) { lost(std::move(why)); },
          .refused =
              [this] {
                bridge_.lost(line_.refusal().text);
                reporter_.line_changed();
              }};
}

Result<void> ZigbeeNetwork::open() {
  opened_ = true;
  lost_ = false;
  if (line_.connected()) return {};
  auto opened = line_.open();
  lost_ = !opened.has_value();
  if (opened) reporter_.line_changed();
  return opened;
}

Result<void> ZigbeeNetwork::reopen() {
  return line_.reopen() ? Result<void>() : Network::reopen();
}

void ZigbeeNetwork::connected() {
  forbidden_.clear();
  not_taken_.clear();
  devices_.connected();
  auto filters = topics_.filters();
  // The version first: the lists of a bridge that we do not speak to are not read. Retained messages come in this
  // order.
  std::stable_partition(filters.begin(), filters.end(),
                        [&](const auto& filter) { return filter == topics_.state("bridge/info"); });
  for (const auto& filter : filters) std::ignore = line_.subscribe(filter);
  bridge_.connected();
  reporter_.line_changed();
}

/// The devices stay: a broker that comes back may have lost the lists (zigbee.md, section 2).
void ZigbeeNetwork::lost(Error why) {
  arrivals_.drain();
  lost_ = true;
  bridge_.lost(why.text);
  host_.failed(std::move(why));
}

void ZigbeeNetwork::too_long(std::string_view topic, std::size_t bytes) {
  if (topic == topics_.state("bridge/devices")) too_long_list_ = bytes;
  log_.warning(fmt::format("too long {}", topic),
               fmt::format("{}: dropped {} bytes, more than largest-packet ({} bytes)", model::quoted(topic), bytes,
                           options_.broker.line.largest_packet));
  reporter_.counters_changed();
}

void ZigbeeNetwork::forbidden(std::string_view filter, const Error& why) {
  log_.warning("forbidden " + std::string(filter),
               fmt::format("the broker forbids to subscribe to {}: {}", model::quoted(filter), why.text));
  if (forbidden_.size() < kMaxRefused) forbidden_.emplace(filter);
  reporter_.line_changed();
}

void ZigbeeNetwork::unsubscribed(std::string_view filter) {
  if (forbidden_.erase(std::string(filter)) > 0) reporter_.counters_changed();
}

void ZigbeeNetwork::not_taken(std::string_view topic, const Error& why) {
  log_.warning("not taken " + std::string(topic), why.text);
  if (not_taken_.size() < kMaxRefused) not_taken_.emplace(topic);
  devices_.not_taken(topic, why.text);
  tools_.not_taken(topic, why.text);
  reporter_.line_changed();
}

void ZigbeeNetwork::passed(std::string_view topic, std::string_view payload, bool outgoing) {
  const auto front = options_.base.size() + 1;
  tools_.passed(topic.size() > front ? topic.substr(front) : topic, payload, outgoing);
}

void ZigbeeNetwork::received(const transport::MqttMessage& message) {
  passed(message.topic, message.payload, false);
  const auto found = topics_.find(message.topic, message.payload);
  if (!found || found->kind == Topics::Kind::kState || found->kind == Topics::Kind::kAvailability) {
    arrivals_.add(message);
  } else {
    from_bridge(*found, message);
  }
}

void ZigbeeNetwork::from_bridge(const Topics::Found& found, const transport::MqttMessage& message) {
  switch (found.kind) {
    case Topics::Kind::kBridgeState:
      arrivals_.drain();  // they came before
      if (auto read = bridge_.state(message.payload, message.retained); !read) unreadable(message, read.error());
      break;
    case Topics::Kind::kInfo: info(message.payload); break;
    case Topics::Kind::kDevices:
      if (bridge_.supported()) devices_.list(message.payload, message.retained);
      break;
    case Topics::Kind::kGroups:
      if (bridge_.supported()) devices_.groups(message.payload);
      break;
    case Topics::Kind::kEvent: event(message.payload); break;
    case Topics::Kind::kHealth: tools_.health(message.payload); break;
    case Topics::Kind::kResponse: response(found.what, message.payload); break;
    case Topics::Kind::kState:
    case Topics::Kind::kAvailability: break;
  }
}

void ZigbeeNetwork::info(std::string_view payload) {
  auto read = bridge::read_info(payload);
  if (read && read->version.empty()) read = fail(ErrorCode::kInvalid, "it has no version");
  if (!read) return unreadable({topics_.state("bridge/info"), {}}, read.error());
  tools_.info(payload, *read);
  devices_.info(*read);
  bridge_.info(std::move(*read));
  reporter_.counters_changed();
}

void ZigbeeNetwork::event(std::string_view payload) {
  const auto read = bridge::read_event(payload);
  if (!read) return unreadable({topics_.state("bridge/event"), {}}, read.error());
  ++events_;
  devices_.event(*read);
  tools_.event(*read);
}

/// To any client: what another one removes is removed here too.
void ZigbeeNetwork::response(std::string_view what, std::string_view payload) {
  if (what == "device/remove") {
    const auto read = bridge::read_response(payload);
    if (read && read->ok) devices_.removed(model::text_of(model::object_of(read->data), "id"));
  }
  tools_.response(payload);
}

void ZigbeeNetwork::unreadable(const transport::MqttMessage& message, const Error& why) {
  ++unreadable_;
  log_.warning(std::string(message.topic), fmt::format("{}: {}", model::quoted(message.topic), why.text));
  reporter_.counters_changed();
}

void ZigbeeNetwork::bridge_changed() {
  const bool up = bridge_.line() == LineState::kUp;
  tools_.use(up, bridge_.reason());
  if (up) {
    devices_.line_up(bridge_.repeats());
    await_list();
    if (!up_) up_since_ = host_.scheduler().now();
    await_states();
  } else if (up_) {
    devices_.line_lost(bridge_.reason());
  }
  up_ = up;
  if (!lost_) reporter_.line_changed();
}

void ZigbeeNetwork::await_list() {
  if (up_) return;
  list_is_late_ = false;
  list_patience_ = host_.scheduler().after(kListTime, [this] {
    list_is_late_ = true;
    if (!devices_.lists_arrived()) reporter_.line_changed();
  });
}

void ZigbeeNetwork::await_states() {
  silence_ = host_.scheduler().after(kSilence, [this] {
    if (!up_ || devices_.heard()) return;
    if (silent_devices() > 0) {
      log_.warning("silence", trouble());
      reporter_.line_changed();
    }
    await_states();
  });
}

/// Without state messages (advanced.output) silence is expected.
std::size_t ZigbeeNetwork::silent_devices() const {
  if (!up_ || devices_.heard() || !devices_.publishes_states()) return 0;
  const auto silence = host_.scheduler().now() - up_since_;
  return silence >= (devices_.answer_is_due() ? kSilence : kLongSilence) ? devices_.usable() : 0;
}

std::string ZigbeeNetwork::trouble() const {
  return line_trouble({.base = options_.base,
                       .user = options_.broker.line.user,
                       .forbidden = forbidden_,
                       .not_taken = not_taken_,
                       .list_missing = list_is_late_ && !devices_.lists_arrived(),
                       .others_came = devices_.known_groups().arrived(),
                       .retains = devices_.bridge_retains(),
                       .too_long = too_long_list_,
                       .largest_packet = options_.broker.line.largest_packet,
                       .silent_devices = silent_devices()});
}

std::string ZigbeeNetwork::unusable() const {
  constexpr std::size_t kMaxCount = 50;
  auto list = nlohmann::json::array();
  for (const auto& one : devices_.unusable_names()) {
    if (list.size() < kMaxCount) list.push_back({{"address", one.address}, {"name", one.name}, {"why", one.why}});
  }
  return model::dump(list);
}

Result<void> ZigbeeNetwork::send(const Message& message) {
  if (message.kind() == MessageKind::kOpaque) return tools_.receive(message);
  return devices_.send(message);
}

/// The line stays if it is the same.
Result<void> ZigbeeNetwork::change(const network::NetworkConfig& config) {
  auto read = network::read_options<read_zigbee_options>(config, host_);
  if (!read) return fail(std::move(read.error()));
  if (!same_line(*read, options_)) return fail(ErrorCode::kUnsupported, "the broker or the base topic changed");
  options_ = std::move(*read);
  devices_.polls_per_second(options_.polls_per_second);
  return {};
}

std::vector<network::Missing> ZigbeeNetwork::missing() const {
  std::vector<network::Missing> missing;
  for (const auto& file : options_.broker.files()) {
    if (auto opened = host_.transports().open_file(file.path); !opened)
      missing.push_back({"broker." + file.option, std::move(opened.error().text)});
  }
  if (auto warning = options_.broker.password_warning(host_.transports()); !warning.empty())
    missing.push_back({"broker.password-file", std::move(warning), network::Missing::Kind::kWarning});
  return missing;
}

std::optional<model::State> ZigbeeNetwork::state() const {
  if (!opened_ || lost_) return std::nullopt;
  model::State state;
  if (line_.connected()) {
    state.line = bridge_.line();
    state.reason = bridge_.reason();
  } else if (!line_.refusal().text.empty()) {
    state.line = LineState::kRefused;
    state.reason = line_.refusal().text;
    state.finding = line_.refusal().finding;
  } else {
    state.line = LineState::kConnecting;
    state.reason =
        fmt::format("connecting to the MQTT broker {}:{}", options_.broker.line.host, options_.broker.line.port);
  }
  if (state.line == LineState::kUp) state.reason = trouble();
  add_counters(state.counters);
  state.texts = tools_.texts();
  state.texts["unusable"] = unusable();
  state.texts["groups"] = devices_.known_groups().members();
  const auto& line = options_.broker.line;
  state.texts["broker"] = model::dump(
      {{"host", line.host}, {"port", line.port}, {"tls", line.tls.has_value()}, {"user", !line.user.empty()}});
  return state;
}

void ZigbeeNetwork::add_counters(std::map<std::string, std::uint64_t>& counters) const {
  const auto& line = line_.counters();
  const auto& devices = devices_.counters();
  const auto& lists = devices_.inventory().counters();
  counters = {
      {"attempts", line_.attempts()},
      {"next-attempt", static_cast<std::uint64_t>(
                           std::chrono::ceil<std::chrono::seconds>(line_.next_attempt().time_since_epoch()).count())},
      {"messages-received", line.received},
      {"messages-sent", line.sent},
      {"messages-not-taken", line.not_taken},
      {"dropped-too-long", line.too_long},
      {"dropped-states", arrivals_.dropped()},
      {"forbidden-topics", forbidden_.size()},
      {"unreadable-messages", unreadable_},
      {"unreadable-states", devices.bad_states},
      {"unreadable-lists", devices.unreadable_lists},
      {"unknown-topics", devices.unknown_topics},
      {"unusable-names", devices_.unusable_names().size()},
      {"skipped-exposes", devices_.gaps().skipped()},
      {"unknown-units", devices_.gaps().unknown_units()},
      {"events", events_},
      {"lists", lists.lists},
      {"lists-compared", lists.compared},
      {"joins", devices.joins},
      {"leaves", devices.leaves},
      {"renames", devices.renames},
      {"states", devices.states},
      {"readings", devices.readings},
      {"sets", devices.sets},
      {"gets", devices.gets}};
}

}  // namespace

const network::NetworkType kType{
    .name = "zigbee",
    .summary = "ZigBee devices, through Zigbee2MQTT and its MQTT broker",
    .sample_config = kSample,
    .make = network::make_network<ZigbeeNetwork, read_zigbee_options>,
    .discovers = true,
    .quiet = true,
    .probes = true,
    .unique_names = true,
    .answer_time = std::chrono::seconds(30),  // a sleeping device takes a command when it wakes
};

}  // namespace rubicon::networks::zigbee
