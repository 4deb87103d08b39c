#include "networks/wsn/wsn_network.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>
#include <tuple>
#include <utility>

#include "base/limited_log.h"
#include "networks/wsn/island_id_keeper.h"
#include "networks/wsn/mote_probes.h"
#include "networks/wsn/mote_properties.h"
#include "networks/wsn/recent_messages.h"
#include "networks/wsn/sampling.h"
#include "networks/wsn/share/forwarder.h"
#include "networks/wsn/sink/packet_recorder.h"
#include "networks/wsn/wsn_options.h"
#include "networks/wsn/wsn_sample.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::wsn {

namespace {

using namespace std::chrono_literals;

constexpr Duration kCountersEvery = 1s;
constexpr Duration kShareAgain = 30s;
/// A full lane is sent within ten seconds; what waited longer was meant for a sink that was away.
constexpr Duration kClientLife = 20s;
/// Of a sink on another island nothing is heard, of any mote.
constexpr Duration kQuiet = 2s;
/// Some of what the supervisor grants is left to name those that did not acknowledge.
constexpr Duration kStopping = network::kClosingTime - 200ms;

class WsnNetwork final : public network::Network {
 public:
  WsnNetwork(const network::NetworkConfig& config, WsnOptions options, network::NetworkHost& host);

  Result<void> open() override;
  Result<void> send(const model::Message& message) override;
  Result<void> change(const network::NetworkConfig& config) override;
  bool close(std::function<void()> closed) override;

 private:
  using NetMessage = motes::NetMessage;
  // The sink.
  sink::SinkCallbacks sink_calls();
  void sink_changed(const sink::SinkState& state);
  void correct_island(std::uint16_t theirs);
  void check_island_if_quiet();
  // Those who share it.
  void share();
  bool take_from_client(ByteView bytes);
  sink::SendCallback overruled_by(const ReadOrder& order);
  // Upwards.
  void received(ByteView bytes);
  void bad_packet(const Error& why);
  void take(motes::MoteEvents& events);
  void deliver(model::Message message);
  void measures(std::uint16_t mote, std::optional<std::uint16_t> mask);
  void show_mask(std::uint16_t mote, std::uint16_t mask);
  // Downwards.
  Result<void> actuate(std::uint16_t mote, const model::Actuate& command);
  Result<void> sample(std::uint16_t mote, const model::Sample& wish);
  Result<void> probe(std::uint16_t mote, const model::Message& message);
  Result<void> opaque(const model::Message& message);
  Result<void> packet_for_sink(const model::Message& message, const MoteTag& tag);
  Result<void> put(MoteRequest request, std::uint64_t number, const model::Message& message);
  void answer(const model::Message& message, std::uint64_t number, DeliveryResult how, std::uint16_t mote);

  bool plays_a_file() const { return options_.source.kind == sink::Source::Kind::kFile; }
  void say_untold(const std::vector<std::uint16_t>& motes, std::string_view why);
  void say(const std::string& subject, std::string_view text);
  void report();
  void report_later();

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
  IslandIdKeeper island_id_keeper_;
  SteadyTime heard_{};  ///< any mote of ours
  base::LimitedLog log_;
  std::uint64_t readings_ = 0, joins_ = 0, bad_packets_ = 0, foreign_ = 0, foreign_motes_ = 0, repeated_ = 0,
                commands_ = 0;
  bool opened_ = false;
  std::string share_reason_;
  Timer counters_, share_again_;
  std::optional<sink::PacketRecorder> recorder_;
  std::optional<share::Forwarder> forwarder_;
  std::unique_ptr<sink::Sink> sink_;  ///< last: goes first, its calls reach all others
};

WsnNetwork::WsnNetwork(const network::NetworkConfig& config, WsnOptions options, network::NetworkHost& host)
    : options_(std::move(options)),
      host_(host),
      types_(config.types),
      island_(static_cast<std::uint16_t>(model::number(config.island))),
      codec_(config.types, options_.codec),
      requests_(
          host.scheduler(), [this](sink::Outgoing packet) { return sink_->send(std::move(packet)); },
          [this] { check_island_if_quiet(); }),
      probes_(island_, host.scheduler(), requests_),
      sampling_(host.scheduler(), requests_, {island_, options_.read_updates},
                {[this](std::uint16_t mote, std::optional<std::uint16_t> mask) { measures(mote, mask); },
                 [this](std::uint16_t mote, std::uint16_t mask) { show_mask(mote, mask); }}),
      properties_(config.types),
      island_id_keeper_(island_, host.scheduler(),
                        [this](sink::Outgoing packet) { return sink_->send(std::move(packet)); }),
      log_(host.limited_log()) {
  const auto note = [this](const std::string& subject, std::string_view text) { say(subject, text); };
  if (!options_.source.record.empty())
    recorder_.emplace(options_.source.record, host.scheduler(), host.transports(), note);
  if (options_.share) {
    share::ForwarderCallbacks calls;
    calls.packet = [this](ByteView packet) { return take_from_client(packet); };
    calls.failed = [this](const Error& why) {
      share_reason_ = why.text;
      share_again_ = host_.scheduler().after(kShareAgain, [this] { share(); });
    };
    calls.note = note;
    forwarder_.emplace(*options_.share, host.scheduler(), host.transports(), std::move(calls));
  }
  sink_ =
      sink::make_sink({options_.source, island_id_keeper_.packet()}, host.scheduler(), host.transports(), sink_calls());
}

sink::SinkCallbacks WsnNetwork::sink_calls() {
  sink::SinkCallbacks calls;
  calls.changed = [this](const sink::SinkState& state) { sink_changed(state); };
  calls.failed = [this](Error why) {
    island_id_keeper_.watch(std::nullopt);
    host_.failed(std::move(why));
  };
  calls.received = [this](ByteView packet) { received(packet); };
  calls.left = [this](ByteView packet) {
    if (recorder_) recorder_->written(packet);
  };
  calls.room = [this](sink::Lane lane) {
    if (lane == sink::Lane::kClient && forwarder_) forwarder_->room();
  };
  calls.note = [this](const std::string& subject, std::string_view text) { say(subject, text); };
  return calls;
}

Result<void> WsnNetwork::open() {
  if (!std::exchange(opened_, true)) {
    if (recorder_) {
      if (auto ready = recorder_->open(); !ready) say("recorder", ready.error().text);
    }
    share();
  }
  return sink_->open();
}

void WsnNetwork::sink_changed(const sink::SinkState& state) {
  if (state.phase == sink::SinkState::Phase::kUp) {
    probes_.forgive();
    if (!island_id_keeper_.watched()) island_id_keeper_.watch(options_.island_check);
  }
  report();
}

void WsnNetwork::correct_island(std::uint16_t theirs) {
  ++foreign_;
  say("foreign-packets", fmt::format("a message for island {} from the sink of island {}: it has (or had) another id; "
                                     "motes that joined it under that id must be switched off and on",
                                     theirs, island_));
  island_id_keeper_.correct();
}

/// Somebody is missed. A sink that was switched off and on is on another island and hears none of our motes; that may
/// be all there is to it.
void WsnNetwork::check_island_if_quiet() {
  if (!options_.island_check || plays_a_file() || host_.scheduler().now() < heard_ + kQuiet) return;
  island_id_keeper_.correct();
}

void WsnNetwork::share() {
  if (!forwarder_) return;
  if (auto ready = forwarder_->open(); !ready) {
    share_reason_ = ready.error().text;
    say("share", fmt::format("the sink cannot be shared: {}", share_reason_));
    share_again_ = host_.scheduler().after(kShareAgain, [this] { share(); });
  } else {
    share_reason_.clear();
  }
  report_later();
}

bool WsnNetwork::take_from_client(ByteView bytes) {
  report_later();
  const auto expires = host_.scheduler().now() + kClientLife;
  const auto packet = motes::decode_whole(bytes);
  const auto order = packet && packet->radio ? read_order_in(*packet->radio) : std::nullopt;
  const bool repeatable = packet && may_repeat(*packet);
  sink::Outgoing out{Bytes(bytes.begin(), bytes.end()), sink::Lane::kClient, expires, repeatable, {}};
  if (order) out.done = overruled_by(*order);
  auto sent = sink_->send(std::move(out));
  if (!sent && sent.error().code == ErrorCode::kBusy) return false;
  if (!sent) say("share", fmt::format("a client's packet cannot be sent: {}", sent.error().text));
  if (sent && order) sampling_.overruled(order->mote, order->mask);
  return true;
}

sink::SendCallback WsnNetwork::overruled_by(const ReadOrder& order) {
  return [this, order](sink::SendResult how) {
    if (!order.mask) return;
    sampling_.obeys_others(order.mote, how == sink::SendResult::kAcknowledged ? order.mask : std::nullopt);
  };
}

void WsnNetwork::received(ByteView bytes) {
  report_later();
  if (forwarder_) forwarder_->tell(bytes);
  if (recorder_) recorder_->read(bytes);
  const auto packet = motes::decode_whole(bytes);
  if (!packet) return bad_packet(packet.error());
  auto events = codec_.interpret(*packet);
  if (!events) return bad_packet(events.error());
  if (events->wants_ack) std::ignore = requests_.send(ack_request(island_, *events->wants_ack));
  const bool repeated = packet->radio && recent_.seen(packet->radio->header, host_.scheduler().now());
  if (repeated) {
    ++repeated_;
  } else {
    take(*events);
  }
}

void WsnNetwork::bad_packet(const Error& why) {
  ++bad_packets_;
  say("bad-packets", why.text);
}

void WsnNetwork::take(motes::MoteEvents& events) {
  if (events.foreign_source) {
    ++foreign_motes_;
    return say("foreign-motes",
               fmt::format("a mote of island {} speaks to this island by radio", *events.foreign_source));
  }
  if (events.foreign_island && events.messages.empty()) return correct_island(*events.foreign_island);
  if (events.joined) recent_.forget(*events.mote);
  for (auto& message : events.messages) deliver(std::move(message));
  if (events.ack && !requests_.heard(*events.ack) && !events.foreign_island) {
    if (auto said = acknowledgement_for_applications(*events.ack)) deliver(std::move(*said));
  }
  if (!events.mote) return;
  heard_ = host_.scheduler().now();
  probes_.heard(*events.mote);
  if (events.joined) {
    ++joins_;
    show_mask(*events.mote, 0);
    sampling_.joined(*events.mote);
  }
  sampling_.heard(*events.mote, events.reported);
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

/// In a recording nothing follows our commands: its reports are shown as they are.
void WsnNetwork::measures(std::uint16_t mote, std::optional<std::uint16_t> mask) {
  if (plays_a_file()) return;
  codec_.measures(mote, mask ? std::optional(motes::MeasuredFields{*mask, 0}) : std::nullopt);
}

void WsnNetwork::show_mask(std::uint16_t mote, std::uint16_t mask) {
  host_.deliver(fmt::format("{}", mote), properties_.reads(mote, mask));
}

Result<void> WsnNetwork::send(const model::Message& message) {
  report_later();
  if (message.kind() == MessageKind::kOpaque) return opaque(message);
  const auto& device = message.destination.device;
  const auto mote = mote_address(device);
  if (!mote) return fail(ErrorCode::kNotFound, fmt::format("no device {}", model::quoted(device)));
  if (message.kind() == MessageKind::kProbe) return probe(*mote, message);
  if (!codec_.knows(*mote)) return fail(ErrorCode::kNotFound, fmt::format("mote {} was never heard", *mote));
  if (const auto* command = std::get_if<model::Actuate>(&message.body)) return actuate(*mote, *command);
  if (const auto* wish = std::get_if<model::Sample>(&message.body)) return sample(*mote, *wish);
  if (const auto* set = std::get_if<model::SetProperty>(&message.body)) {
    const bool mask = set->point.type == types_.find("mask")->id;
    return mask ? fail(ErrorCode::kRefused, "what a mote reads follows who subscribes: its mask cannot be set")
                : fail(ErrorCode::kNotFound, fmt::format("mote {} has no such property", *mote));
  }
  return fail(ErrorCode::kUnsupported, fmt::format("motes take no {}", to_string(message.kind())));
}

Result<void> WsnNetwork::actuate(std::uint16_t mote, const model::Actuate& command) {
  if (!codec_.offers(mote, command.point))
    return fail(ErrorCode::kNotFound, fmt::format("mote {} has no such actuator", mote));
  const auto* type = types_.find(command.point.type);
  auto request = actuate_request(island_, mote, type ? type->name : std::string_view(), command);
  if (!request) return fail(request.error());
  model::Message asked;
  asked.destination.device = fmt::format("{}", mote);
  auto sent = put(std::move(*request), command.request, asked);
  if (sent) ++commands_;
  return sent;
}

Result<void> WsnNetwork::put(MoteRequest request, std::uint64_t number, const model::Message& message) {
  const auto mote = request.header.destination_mote;
  model::Message asked;
  asked.source = message.source;
  asked.destination = message.destination;
  const auto order = read_order_in(request);
  request.done = [this, asked, number, mote, order](DeliveryResult how) {
    if (order)
      overruled_by (*order)(how == DeliveryResult::kAcknowledged ? sink::SendResult::kAcknowledged
                                                                 : sink::SendResult::kNotAcknowledged);
    answer(asked, number, how, mote);
  };
  auto sent = requests_.send(std::move(request));
  if (sent && order) sampling_.overruled(order->mote, order->mask);
  return sent;
}

void WsnNetwork::answer(const model::Message& message, std::uint64_t number, DeliveryResult how, std::uint16_t mote) {
  model::Message out;
  out.source.device = message.destination.device;
  out.destination = message.source;
  out.body = acknowledge_of(number, how, mote);
  host_.deliver(std::move(out));
  report_later();
}

Result<void> WsnNetwork::sample(std::uint16_t mote, const model::Sample& wish) {
  if (plays_a_file()) return fail(ErrorCode::kRefused, "recorded motes report when they did");
  Reads reads;
  for (const auto& point : wish.points) {
    reads.mask |= codec_.transducer_of(mote, point);
  }
  if (reads.mask == 0 && !wish.points.empty())
    return fail(ErrorCode::kNotFound,
                fmt::format("mote {} has none of the {} sensors that are asked for", mote, wish.points.size()));
  if (reads.mask != 0) reads.ticks = ticks_of(wish.period);
  if (reads.mask != 0 && sampling_.obeys(mote, reads)) check_island_if_quiet();  // its reports are missed
  if (auto wanted = sampling_.want(mote, reads); !wanted) return wanted;
  host_.deliver(fmt::format("{}", mote), model::Acknowledge{wish.request, model::Outcome::kSent, {}});
  return {};
}

Result<void> WsnNetwork::probe(std::uint16_t mote, const model::Message& message) {
  if (plays_a_file()) return fail(ErrorCode::kRefused, "recorded motes cannot be asked");
  if (message.source.island == IslandId{island_} && message.source.network.empty()) {
    if (auto join = codec_.know(mote, std::get<model::Probe>(message.body).known)) deliver(std::move(*join));
  }
  if (!codec_.knows(mote)) return fail(ErrorCode::kNotFound, fmt::format("mote {} was never heard", mote));
  model::Message asked;
  asked.source = message.source;
  asked.destination = message.destination;
  return probes_.ask(
      mote, [this, asked, number = message.number, mote](DeliveryResult how) { answer(asked, number, how, mote); });
}

Result<void> WsnNetwork::opaque(const model::Message& message) {
  const auto tag = parse_tag(std::get<model::Opaque>(message.body).type);
  if (!tag) return fail(tag.error());
  if (tag->kind == MoteTag::Kind::kAm) return packet_for_sink(message, *tag);
  const auto mote = mote_address(message.destination.device, true);
  if (!mote) return fail(ErrorCode::kNotFound, fmt::format("no mote {}", model::quoted(message.destination.device)));
  auto request = opaque_request(island_, *mote, message, *tag);
  if (!request) return fail(request.error());
  return put(std::move(*request), message.number, message);
}

/// Packets of other AM types, past the motes' network layer (wsn.md 7.2).
Result<void> WsnNetwork::packet_for_sink(const model::Message& message, const MoteTag& tag) {
  auto packet = am_packet(message, tag);
  if (!packet) return fail(packet.error());
  model::Message asked;
  asked.source = message.source;
  asked.destination = message.destination;
  sink::Outgoing out{std::move(*packet), sink::Lane::kCommand, host_.scheduler().now() + 5s, false, {}};
  out.done = [this, asked, number = message.number](sink::SendResult how) {
    answer(asked, number,
           how == sink::SendResult::kAcknowledged ? DeliveryResult::kAcknowledged
           : how == sink::SendResult::kExpired    ? DeliveryResult::kExpired
           : how == sink::SendResult::kRefused    ? DeliveryResult::kRefused
                                                  : DeliveryResult::kSinkSilent,
           motes::kSinkMote);
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
  if (sink_->state().phase == sink::SinkState::Phase::kUp) island_id_keeper_.watch(options_.island_check);
  return {};
}

/// The firmware has no stop, so that a mote that gets no other command reports for ever (wsn.md 9.4).
bool WsnNetwork::close(std::function<void()> closed) {
  const auto woken = sampling_.woken();
  if (sink_->state().phase != sink::SinkState::Phase::kUp) {
    say_untold(woken, "the sink is away");
    return false;
  }
  return sampling_.close(kStopping, [this, closed = std::move(closed)](const auto& untold) {
    say_untold(untold, "they did not acknowledge in time");
    closed();
  });
}

void WsnNetwork::say_untold(const std::vector<std::uint16_t>& motes, std::string_view why) {
  if (motes.empty()) return;
  log_.unlimited().warning(
      fmt::format("motes {} go on sampling, the command to stop did not reach them: {}", fmt::join(motes, ", "), why));
}

/// At most one line a minute and subject; the counters have all.
void WsnNetwork::say(const std::string& subject, std::string_view text) {
  report_later();
  log_.warning(subject, text);
}

void WsnNetwork::report_later() {
  if (counters_.pending() || !opened_) return;
  counters_ = host_.scheduler().after(kCountersEvery, [this] { report(); });
}

/// While the line is lost, the supervisor speaks for it.
void WsnNetwork::report() {
  using Phase = sink::SinkState::Phase;
  const auto& sink = sink_->state();
  if (sink.phase == Phase::kOff) return;
  model::State state{sink.phase == Phase::kUp      ? model::LineState::kUp
                     : sink.phase == Phase::kEnded ? model::LineState::kEnded
                                                   : model::LineState::kConnecting,
                     sink.reason, sink_->counters()};
  state.counters.insert({{"readings", readings_},
                         {"joins", joins_},
                         {"commands", commands_},
                         {"probes", probes_.asked()},
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
    state.texts["share"] = share_reason_.empty() ? transport::to_string(forwarder_->local()) : share_reason_;
  }
  if (recorder_) {
    for (const auto& [name, count] : recorder_->counters()) state.counters["record-" + name] = count;
  }
  host_.deliver("", std::move(state));
}

}  // namespace

const network::NetworkType kType{
    .name = "wsn",
    .summary = "802.15.4 motes of TinyOS behind a sink, over a serial line or a serial forwarder",
    .sample_config = kSample,
    .make = network::make_network<WsnNetwork, read_wsn_options>,
    .probes = true,
};

}  // namespace rubicon::networks::wsn
