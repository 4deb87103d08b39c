#include "networks/wsn/wsn_network.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>
#include <tuple>
#include <utility>

#include "base/log.h"
#include "network/line_reports.h"
#include "networks/wsn/packet_monitor.h"
#include "networks/wsn/recent_messages.h"
#include "networks/wsn/sampling.h"
#include "networks/wsn/share/forwarder.h"
#include "networks/wsn/sink/packet_logs.h"
#include "networks/wsn/upkeep.h"
#include "networks/wsn/wsn_options.h"
#include "networks/wsn/wsn_sample.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::wsn {

namespace {

using namespace std::chrono_literals;
using sink::SendResult;
using Phase = sink::SinkState::Phase;

/// Between attempts to open the port of the forwarder.
constexpr Duration kShareRetry = 30s;
/// A full lane is sent within ten seconds; a packet that waited longer was meant for a sink that was away.
constexpr Duration kClientPacketLifetime = 20s;
/// While the sink has another island id, no mote is heard for at least this long.
constexpr Duration kSilence = 2s;
/// Leaves some of the time that the supervisor grants, to log the motes that did not acknowledge.
constexpr Duration kStopTimeout = network::kClosingTime - 200ms;

/// Source and destination of a request, to answer it.
model::Message envelope_of(const model::Message& message) {
  model::Message envelope;
  envelope.source = message.source;
  envelope.destination = message.destination;
  return envelope;
}

class WsnNetwork final : public network::Network {
 public:
  WsnNetwork(const network::NetworkConfig& config, WsnOptions options, network::NetworkHost& host);

  Result<void> open() override;
  Result<void> send(const model::Message& message) override;
  Result<void> change(const network::NetworkConfig& config) override;
  bool close(std::function<void()> closed) override;

 private:
  // The sink.
  sink::SinkCallbacks sink_callbacks();
  void sink_changed(const sink::SinkState& state);
  void correct_island(std::uint16_t theirs);
  void correct_island_if_silent();
  // The clients that share it.
  share::ForwarderCallbacks forwarder_callbacks();
  void share();
  void retry_share();
  bool take_from_client(ByteView bytes);
  void end_override(const ReadOrder& order, bool acknowledged);
  // Upwards.
  void received(ByteView bytes);
  void bad_packet(const Error& why);
  void apply(motes::MoteEvents& events);
  void mote_heard(std::uint16_t mote, const motes::MoteEvents& events);
  void deliver(model::Message message);
  void set_measured(std::uint16_t mote, std::optional<std::uint16_t> mask);
  void show_mask(std::uint16_t mote, std::uint16_t mask);
  // Downwards.
  Result<void> actuate(std::uint16_t mote, const model::Actuate& command);
  Result<void> sample(std::uint16_t mote, const model::Sample& sample);
  Result<void> set_property(std::uint16_t mote, const model::SetProperty& set) const;
  Result<void> probe(std::uint16_t mote, const model::Message& message);
  Result<void> opaque(const model::Message& message);
  Result<void> packet_for_sink(const model::Message& message, const MoteTag& tag);
  Result<void> request(MoteRequest request, std::uint64_t number, const model::Message& message);
  void answer(const model::Message& envelope, std::uint64_t number, DeliveryResult result, std::uint16_t mote);

  bool plays_a_file() const { return options_.source.kind == sink::Source::Kind::kFile; }
  void warn_of_active(const std::vector<std::uint16_t>& motes, std::string_view why) const;
  void note(const std::string& subject, std::string_view text);
  std::optional<model::State> state() const;

  WsnOptions options_;
  network::NetworkHost& host_;
  const TypeCatalogue& types_;
  std::uint16_t island_;
  motes::MoteCodec codec_;
  MoteRequests requests_;
  MoteProbes probes_;
  Sampling sampling_;
  RecentMessages recent_;
  MoteProperties properties_;
  PacketMonitor monitor_;
  IslandIdKeeper island_id_keeper_;
  SteadyTime last_heard_{};  ///< any mote of ours
  base::LimitedLog log_;
  network::StateReporter reporter_;
  std::uint64_t readings_ = 0, joins_ = 0, bad_packets_ = 0, foreign_ = 0, foreign_motes_ = 0, repeated_ = 0,
                commands_ = 0;
  bool opened_ = false;
  std::string share_error_;
  Timer share_retry_;
  std::optional<sink::PacketRecorder> recorder_;
  std::optional<share::Forwarder> forwarder_;
  std::unique_ptr<sink::Sink> sink_;  ///< last: destroyed first, because its callbacks use all others
};

WsnNetwork::WsnNetwork(const network::NetworkConfig& config, WsnOptions options, network::NetworkHost& host)
    : options_(std::move(options)),
      host_(host),
      types_(config.types),
      island_(static_cast<std::uint16_t>(model::number(config.island))),
      codec_(config.types, options_.codec),
      requests_(
          host.scheduler(), [this](sink::Outgoing packet) { return sink_->send(std::move(packet)); },
          [this] { correct_island_if_silent(); }),
      probes_(island_, host.scheduler(), requests_),
      sampling_(host.scheduler(), requests_, {island_, options_.read_updates},
                {[this](std::uint16_t mote, std::optional<std::uint16_t> mask) { set_measured(mote, mask); },
                 [this](std::uint16_t mote, std::uint16_t mask) { show_mask(mote, mask); }}),
      properties_(config.types),
      monitor_(host, [this] { return sink_->state().phase == Phase::kUp; }),
      island_id_keeper_(island_, host.scheduler(),
                        [this](sink::Outgoing packet) { return sink_->send(std::move(packet)); }),
      log_(host.limited_log()),
      reporter_(host, [this] { return state(); }) {
  if (!options_.source.record.empty())
    recorder_.emplace(options_.source.record, host.scheduler(), host.transports(),
                      [this](const std::string& subject, std::string_view text) { note(subject, text); });
  if (options_.share) forwarder_.emplace(*options_.share, host.scheduler(), host.transports(), forwarder_callbacks());
  sink_ = sink::make_sink({options_.source, island_id_keeper_.packet()}, host.scheduler(), host.transports(),
                          sink_callbacks());
}

sink::SinkCallbacks WsnNetwork::sink_callbacks() {
  sink::SinkCallbacks callbacks;
  callbacks.changed = [this](const sink::SinkState& state) { sink_changed(state); };
  callbacks.failed = [this](Error why) {
    island_id_keeper_.repeat(std::nullopt);
    host_.failed(std::move(why));
  };
  callbacks.received = [this](ByteView packet) { received(packet); };
  callbacks.sent = [this](ByteView packet) {
    if (recorder_) recorder_->written(packet);
    monitor_.sent(packet);
  };
  callbacks.room = [this](sink::Lane lane) {
    if (lane == sink::Lane::kClient && forwarder_) forwarder_->resume();
  };
  callbacks.note = [this](const std::string& subject, std::string_view text) { note(subject, text); };
  return callbacks;
}

Result<void> WsnNetwork::open() {
  if (!std::exchange(opened_, true)) {
    if (recorder_) {
      if (auto ready = recorder_->open(); !ready) note("recorder", ready.error().text);
    }
    share();
  }
  return sink_->open();
}

void WsnNetwork::sink_changed(const sink::SinkState& state) {
  if (state.phase == Phase::kUp) {
    probes_.forget_lost();
    if (!island_id_keeper_.repeats()) island_id_keeper_.repeat(options_.island_check);
  }
  reporter_.line_changed();
}

void WsnNetwork::correct_island(std::uint16_t theirs) {
  ++foreign_;
  note("foreign-packets", fmt::format("the sink passed on a message for island {}: it has or had that id instead of "
                                      "{}; switch the motes that joined it meanwhile off and on",
                                      theirs, island_));
  island_id_keeper_.correct();
}

/// Looks for a cause of missing answers and reports: a sink that was switched off and on has another island id and
/// hears none of our motes.
void WsnNetwork::correct_island_if_silent() {
  if (!options_.island_check || plays_a_file() || host_.scheduler().now() < last_heard_ + kSilence) return;
  island_id_keeper_.correct();
}

share::ForwarderCallbacks WsnNetwork::forwarder_callbacks() {
  share::ForwarderCallbacks callbacks;
  callbacks.packet = [this](ByteView packet) { return take_from_client(packet); };
  callbacks.failed = [this](const Error& why) {
    share_error_ = why.text;
    retry_share();
  };
  callbacks.note = [this](const std::string& subject, std::string_view text) { note(subject, text); };
  return callbacks;
}

void WsnNetwork::share() {
  if (!forwarder_) return;
  share_error_.clear();
  if (auto ready = forwarder_->open(); !ready) {
    share_error_ = ready.error().text;
    note("share", fmt::format("the sink is not shared: {}", share_error_));
    retry_share();
  }
  reporter_.counters_changed();
}

void WsnNetwork::retry_share() {
  share_retry_ = host_.scheduler().after(kShareRetry, [this] { share(); });
}

bool WsnNetwork::take_from_client(ByteView bytes) {
  reporter_.counters_changed();
  const auto expires = host_.scheduler().now() + kClientPacketLifetime;
  const auto packet = motes::decode_whole(bytes);
  const auto order = packet && packet->radio ? read_order_in(*packet->radio) : std::nullopt;
  const bool repeatable = packet && may_repeat(*packet);
  sink::Outgoing out{Bytes(bytes.begin(), bytes.end()), sink::Lane::kClient, expires, repeatable, {}};
  if (order)
    out.done = [this, order = *order](SendResult result) { end_override(order, result == SendResult::kAcknowledged); };
  auto sent = sink_->send(std::move(out));
  if (!sent && sent.error().code == ErrorCode::kBusy) return false;
  if (!sent) note("share", fmt::format("a client's packet was not sent: {}", sent.error().text));
  if (sent && order) sampling_.override_begins(order->mote, order->mask);
  return true;
}

void WsnNetwork::end_override(const ReadOrder& order, bool acknowledged) {
  if (order.mask) sampling_.override_ends(order.mote, acknowledged ? order.mask : std::nullopt);
}

void WsnNetwork::received(ByteView bytes) {
  reporter_.counters_changed();
  if (forwarder_) forwarder_->broadcast(bytes);
  if (recorder_) recorder_->read(bytes);
  monitor_.received(bytes);
  const auto packet = motes::decode_whole(bytes);
  if (!packet) return bad_packet(packet.error());
  auto events = codec_.interpret(*packet);
  if (!events) return bad_packet(events.error());
  if (events->wants_ack) std::ignore = requests_.send(ack_request(island_, *events->wants_ack));
  const bool repeated = packet->radio && recent_.seen(packet->radio->header, host_.scheduler().now());
  if (repeated) {
    ++repeated_;
  } else {
    apply(*events);
  }
}

void WsnNetwork::bad_packet(const Error& why) {
  ++bad_packets_;
  note("bad-packets", why.text);
}

void WsnNetwork::apply(motes::MoteEvents& events) {
  if (events.foreign_source) {
    ++foreign_motes_;
    return note("foreign-motes", fmt::format("ignored a radio message of a mote of island {}", *events.foreign_source));
  }
  if (events.foreign_island && events.messages.empty()) return correct_island(*events.foreign_island);
  if (events.joined) recent_.forget(*events.mote);
  for (auto& message : events.messages) deliver(std::move(message));
  if (events.ack && !requests_.acknowledged(*events.ack) && !events.foreign_island) {
    if (auto message = acknowledgement_for_applications(*events.ack)) deliver(std::move(*message));
  }
  if (events.mote) mote_heard(*events.mote, events);
}

void WsnNetwork::mote_heard(std::uint16_t mote, const motes::MoteEvents& events) {
  last_heard_ = host_.scheduler().now();
  probes_.heard(mote);
  if (events.joined) {
    ++joins_;
    show_mask(mote, 0);
    sampling_.joined(mote);
  }
  sampling_.heard(mote, events.reported);
}

void WsnNetwork::deliver(model::Message message) {
  if (auto* join = std::get_if<model::Join>(&message.body))
    properties_.declare(mote_address(message.source.device).value_or(0), *join);
  if (const auto* updates = std::get_if<model::Updates>(&message.body)) readings_ += updates->readings.size();
  auto* opaque = std::get_if<model::Opaque>(&message.body);
  if (opaque && message.destination.island == model::kNoOwner) {
    message.destination.island = options_.messages_to;
    if (auto json = options_.messages_as_json ? as_json(*opaque) : std::nullopt) *opaque = std::move(*json);
  }
  host_.deliver(std::move(message));
}

/// Not for recordings, which do not follow our commands: all fields of their reports are shown.
void WsnNetwork::set_measured(std::uint16_t mote, std::optional<std::uint16_t> mask) {
  if (plays_a_file()) return;
  codec_.set_measured(mote, mask ? std::optional(motes::MeasuredFields{*mask, 0}) : std::nullopt);
}

void WsnNetwork::show_mask(std::uint16_t mote, std::uint16_t mask) {
  host_.deliver(fmt::format("{}", mote), properties_.set_mask(mote, mask));
}

Result<void> WsnNetwork::send(const model::Message& message) {
  reporter_.counters_changed();
  if (message.kind() == MessageKind::kOpaque) return opaque(message);
  const auto& device = message.destination.device;
  const auto mote = mote_address(device);
  if (!mote) return fail(ErrorCode::kNotFound, fmt::format("no device {}", model::quoted(device)));
  if (message.kind() == MessageKind::kProbe) return probe(*mote, message);
  if (!codec_.knows(*mote)) return fail(ErrorCode::kNotFound, fmt::format("mote {} was never heard", *mote));
  if (const auto* command = std::get_if<model::Actuate>(&message.body)) return actuate(*mote, *command);
  if (const auto* request = std::get_if<model::Sample>(&message.body)) return sample(*mote, *request);
  if (const auto* set = std::get_if<model::SetProperty>(&message.body)) return set_property(*mote, *set);
  return fail(ErrorCode::kUnsupported, fmt::format("motes do not support {}", to_string(message.kind())));
}

Result<void> WsnNetwork::set_property(std::uint16_t mote, const model::SetProperty& set) const {
  const bool mask = set.point.type == types_.find("mask")->id;
  return mask ? fail(ErrorCode::kRefused, "the mask cannot be set: a mote reads what is subscribed to")
              : fail(ErrorCode::kNotFound, fmt::format("mote {} has no such property", mote));
}

Result<void> WsnNetwork::actuate(std::uint16_t mote, const model::Actuate& command) {
  if (!codec_.offers(mote, command.point))
    return fail(ErrorCode::kNotFound, fmt::format("mote {} has no such actuator", mote));
  const auto* type = types_.find(command.point.type);
  auto actuation = actuate_request(island_, mote, type ? type->name : std::string_view(), command);
  if (!actuation) return fail(actuation.error());
  model::Message from;
  from.destination.device = fmt::format("{}", mote);
  auto sent = request(std::move(*actuation), command.request, from);
  if (sent) ++commands_;
  return sent;
}

Result<void> WsnNetwork::request(MoteRequest request, std::uint64_t number, const model::Message& message) {
  const auto mote = request.header.destination_mote;
  const auto order = read_order_in(request);
  request.done = [this, envelope = envelope_of(message), number, mote, order](DeliveryResult result) {
    if (order) end_override(*order, result == DeliveryResult::kAcknowledged);
    answer(envelope, number, result, mote);
  };
  auto sent = requests_.send(std::move(request));
  if (sent && order) sampling_.override_begins(order->mote, order->mask);
  return sent;
}

void WsnNetwork::answer(const model::Message& envelope, std::uint64_t number, DeliveryResult result,
                        std::uint16_t mote) {
  model::Message out;
  out.source.device = envelope.destination.device;
  out.destination = envelope.source;
  out.body = acknowledge_of(number, result, mote);
  host_.deliver(std::move(out));
  reporter_.counters_changed();
}

Result<void> WsnNetwork::sample(std::uint16_t mote, const model::Sample& sample) {
  if (plays_a_file()) return fail(ErrorCode::kRefused, "the motes of a recording cannot be commanded to sample");
  SampleSetting setting;
  for (const auto& point : sample.points) setting.mask |= codec_.transducer_of(mote, point);
  if (setting.mask == 0 && !sample.points.empty())
    return fail(ErrorCode::kNotFound,
                fmt::format("mote {} has none of the {} requested sensors", mote, sample.points.size()));
  if (setting.mask != 0) setting.ticks = ticks_of(sample.period);
  const bool reports_missing = setting.mask != 0 && sampling_.has_acknowledged(mote, setting);
  if (reports_missing) correct_island_if_silent();
  if (auto demanded = sampling_.demand(mote, setting); !demanded) return demanded;
  host_.deliver(fmt::format("{}", mote), model::Acknowledge{sample.request, model::Outcome::kSent, {}});
  return {};
}

Result<void> WsnNetwork::probe(std::uint16_t mote, const model::Message& message) {
  if (plays_a_file()) return fail(ErrorCode::kRefused, "the motes of a recording cannot be probed");
  if (message.source.island == IslandId{island_} && message.source.network.empty()) {
    if (auto join = codec_.remember(mote, std::get<model::Probe>(message.body).known)) deliver(std::move(*join));
  }
  if (!codec_.knows(mote)) return fail(ErrorCode::kNotFound, fmt::format("mote {} was never heard", mote));
  return probes_.probe(mote, [this, envelope = envelope_of(message), number = message.number,
                              mote](DeliveryResult result) { answer(envelope, number, result, mote); });
}

Result<void> WsnNetwork::opaque(const model::Message& message) {
  if (std::get<model::Opaque>(message.body).type == kRequestTag) return monitor_.receive(message);
  const auto tag = parse_tag(std::get<model::Opaque>(message.body).type);
  if (!tag) return fail(tag.error());
  if (tag->kind == MoteTag::Kind::kAm) return packet_for_sink(message, *tag);
  const auto mote = receiver_address(message.destination.device);
  if (!mote)
    return fail(ErrorCode::kNotFound, fmt::format("no mote {} (a message to all motes is addressed to the network)",
                                                  model::quoted(message.destination.device)));
  auto to_mote = opaque_request(island_, *mote, message, *tag);
  if (!to_mote) return fail(to_mote.error());
  return request(std::move(*to_mote), message.number, message);
}

/// Packets of other AM types, outside the motes' network layer (wsn.md 7.2).
Result<void> WsnNetwork::packet_for_sink(const model::Message& message, const MoteTag& tag) {
  auto packet = am_packet(message, tag);
  if (!packet) return fail(packet.error());
  sink::Outgoing out{std::move(*packet), sink::Lane::kCommand, host_.scheduler().now() + 5s, false, {}};
  out.done = [this, envelope = envelope_of(message), number = message.number](SendResult result) {
    answer(envelope, number, delivery_result_of(result), motes::kSinkMote);
  };
  return sink_->send(std::move(out));
}

Result<void> WsnNetwork::change(const network::NetworkConfig& config) {
  auto read = network::read_options<read_wsn_options>(config, host_);
  if (!read) return fail(std::move(read.error()));
  WsnOptions next = std::move(*read);
  if (!(next.source == options_.source) || next.share != options_.share)
    return fail(ErrorCode::kUnsupported, "the line changes");
  options_ = std::move(next);
  sampling_.change({island_, options_.read_updates});
  for (auto& join : codec_.change(options_.codec)) deliver(std::move(join));
  if (sink_->state().phase == Phase::kUp) island_id_keeper_.repeat(options_.island_check);
  return {};
}

/// The firmware has no stop: a mote reports until it gets another command (wsn.md 9.4).
bool WsnNetwork::close(std::function<void()> closed) {
  const auto active = sampling_.active();
  if (sink_->state().phase != Phase::kUp) {
    warn_of_active(active, "the sink is away");
    return false;
  }
  return sampling_.close(kStopTimeout, [this, closed = std::move(closed)](const auto& still_active) {
    warn_of_active(still_active, "they did not acknowledge in time");
    closed();
  });
}

void WsnNetwork::warn_of_active(const std::vector<std::uint16_t>& motes, std::string_view why) const {
  if (motes.empty()) return;
  log_.unlimited().warning(
      fmt::format("motes {} go on sampling, the command to stop did not reach them: {}", fmt::join(motes, ", "), why));
}

void WsnNetwork::note(const std::string& subject, std::string_view text) {
  reporter_.counters_changed();
  log_.warning(subject, text);
}

/// nullopt while the line is lost: the supervisor then reports the state.
std::optional<model::State> WsnNetwork::state() const {
  const auto& sink = sink_->state();
  if (sink.phase == Phase::kOff) return std::nullopt;
  model::State state{sink.phase == Phase::kUp      ? model::LineState::kUp
                     : sink.phase == Phase::kEnded ? model::LineState::kEnded
                                                   : model::LineState::kConnecting,
                     sink.reason, sink_->counters()};
  state.counters.insert({{"readings", readings_},
                         {"joins", joins_},
                         {"commands", commands_},
                         {"probes", probes_.sent()},
                         {"waiting-probes", probes_.waiting()},
                         {"lost-motes", probes_.lost()},
                         {"pending-messages", requests_.pending()},
                         {"unanswered-messages", requests_.unanswered()},
                         {"bad-packets", bad_packets_},
                         {"foreign-packets", foreign_},
                         {"foreign-motes", foreign_motes_},
                         {"repeated-messages", repeated_}});
  state.texts["source"] = to_string(options_.source);
  if (forwarder_) {
    for (const auto& [name, count] : forwarder_->counters()) state.counters["share-" + name] = count;
    state.texts["share"] = share_error_.empty() ? transport::to_string(forwarder_->local()) : share_error_;
  }
  if (recorder_) {
    for (const auto& [name, count] : recorder_->counters()) state.counters["record-" + name] = count;
  }
  return state;
}

}  // namespace

const network::NetworkType kType{
    .name = "wsn",
    .summary = "802.15.4 motes of TinyOS behind a sink, over a serial line or a serial forwarder",
    .sample_config = kSample,
    .make = network::make_network<WsnNetwork, read_wsn_options>,
    .discovers = true,
    .probes = true,
};

}  // namespace rubicon::networks::wsn
