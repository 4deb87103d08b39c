#include "networks/knx/line/routing.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "networks/knx/wire/cemi.h"

namespace rubicon::networks::knx::line {

namespace {

/// Own frames that are remembered, to recognise them when they are received back (as Calimero does).
constexpr std::size_t kRememberedFrames = 20;
/// Attempts to send a frame that the operating system has no buffer for.
constexpr unsigned kMaxSendAttempts = 50;

}  // namespace

Routing::Routing(Scheduler& scheduler, Options options, Callbacks callbacks)
    : scheduler_(scheduler),
      options_(options),
      callbacks_(std::move(callbacks)),
      telegrams_(scheduler, options.limits, [this] { pump(); }),
      busy_rule_(options.seed),
      wake_(scheduler, [this] { pump(); }) {}

void Routing::up(Endpoint own) {
  own_ = std::move(own);
  up_ = true;
  wake_.set(Duration::zero());
}

void Routing::down() {
  if (!std::exchange(up_, false)) return;
  telegrams_.line_lost();
  attempts_ = 0;
  sent_.clear();
}

void Routing::send(wire::Telegram telegram, SteadyTime expires, SendCallback done) {
  telegram.source = options_.address;
  telegrams_.push(std::move(telegram), expires, std::move(done));
}

/// True while a router is busy or the last frame is too recent; pump() then runs later.
bool Routing::must_wait() {
  const auto now = scheduler_.now();
  const auto earliest = std::max(next_at_, busy_rule_.resume_at());
  if (now < earliest) wake_.set_at(earliest);
  return now < earliest;
}

void Routing::pump() {
  if (!up_ || must_wait()) return;
  if (!busy_router_.empty()) {
    busy_router_.clear();
    wake_.set(Duration::zero());
    return callbacks_.changed();
  }
  if (telegrams_.in_flight()) return transmit();
  const auto* telegram = telegrams_.take();
  if (telegram == nullptr) return;
  auto cemi = encode(options_.guard, wire::CemiCode::kDataIndication, *telegram, options_.address);
  if (!cemi) {
    wake_.set(Duration::zero());
    return telegrams_.finish(SendOutcome::kRefused, cemi.error().text);
  }
  cemi_ = std::move(*cemi);
  frame_ = write(wire::Message(wire::RoutingIndication{cemi_}));
  transmit();
}

/// Routing has no confirmations: a telegram counts as sent when it was transmitted.
void Routing::transmit() {
  const auto now = scheduler_.now();
  next_at_ = now + (busy_rule_.slow(now) ? 2 * options_.gap : options_.gap);
  wake_.set_at(next_at_);
  const auto sent = callbacks_.send(frame_);
  if (!sent) {
    ++counters_.retries;
    if (sent.error().code != ErrorCode::kBusy || ++attempts_ >= kMaxSendAttempts) give_up(sent.error());
    return;
  }
  attempts_ = 0;
  ++counters_.sent;
  sent_.push_back(cemi_);
  if (sent_.size() > kRememberedFrames) sent_.pop_front();
  const auto watch = lifetime_.watch();
  const auto cemi = std::exchange(cemi_, {});
  callbacks_.frame(cemi, true);
  if (!watch.ended()) telegrams_.finish(SendOutcome::kSent, "");
}

void Routing::give_up(Error why) {
  down();
  callbacks_.failed(std::move(why));
}

void Routing::receive(const Endpoint& from, ByteView datagram, Group group) {
  const auto message = wire::read_message(datagram);
  if (!message) {
    ++counters_.bad;
    return note("bad-frames", from, fmt::format("sent a frame that cannot be read: {}", message.error().text));
  }
  if (const auto* routed = std::get_if<wire::RoutingIndication>(&*message))
    return receive_indication(from, *routed, group);
  if (std::holds_alternative<wire::SearchRequest>(*message) || std::holds_alternative<wire::SearchResponse>(*message))
    return callbacks_.discovery(from, datagram);
  if (group == Group::kSystem) return;
  if (const auto* busy = std::get_if<wire::RoutingBusy>(&*message)) return receive_busy(from, *busy);
  if (const auto* lost = std::get_if<wire::RoutingLostMessage>(&*message)) {
    counters_.lost += lost->lost;
    const auto watch = lifetime_.watch();
    note("lost-messages", from, fmt::format("lost {} telegrams (device state {:02x})", lost->lost, lost->device_state));
    if (!watch.ended()) callbacks_.lost(from, *lost);
    return;
  }
  ++counters_.other;
  if (const auto* other = std::get_if<wire::OtherService>(&*message))
    note("unknown-services", from, fmt::format("sent {}: ignored", to_string(other->service)));
}

void Routing::note(const std::string& subject, const Endpoint& from, std::string_view what) {
  if (callbacks_.note) callbacks_.note(subject, fmt::format("{} {}", transport::to_string(from), what));
}

/// System broadcasts use 224.0.23.12 only, all other frames the routing group only. Others are counted and ignored.
void Routing::receive_indication(const Endpoint& from, const wire::RoutingIndication& indication, Group group) {
  const auto foreign = indication.system_broadcast ? Group::kConfigured : Group::kSystem;
  if (group == foreign) {
    ++counters_.other;
    return;
  }
  if (is_own(from, indication.cemi)) {
    ++counters_.own;
    return;
  }
  const auto frame = wire::read_data_frame(indication.cemi);
  if (!frame || frame->code != wire::CemiCode::kDataIndication) {
    ++(frame || frame.error().code == ErrorCode::kUnsupported ? counters_.other : counters_.bad);
    return callbacks_.frame(indication.cemi, false);
  }
  const auto watch = lifetime_.watch();
  callbacks_.frame(indication.cemi, false);
  if (watch.ended()) return;
  check_source_address(from, indication.cemi);
  if (watch.ended()) return;
  if (!indication.system_broadcast) return receive_telegram(from, *frame);
  ++counters_.other;
}

void Routing::receive_telegram(const Endpoint& from, const wire::DataFrame& frame) {
  const auto telegram = decode(options_.guard, frame, options_.address);
  if (telegram) {
    ++counters_.received;
    return callbacks_.received(*telegram);
  }
  const auto& dropped = telegram.error();
  if (!dropped.counter().empty()) return note(std::string(dropped.counter()), from, "routed a " + dropped.why);
  ++counters_.other;
}

/// No other program of this machine uses our port. If our own address is unknown, another machine may use the same
/// port.
bool Routing::is_own(const Endpoint& from, ByteView cemi) {
  if (from.port != own_.port) return false;
  if (!own_.address.empty()) return from.address == own_.address;
  const auto same = [&](const Bytes& sent) { return std::equal(sent.begin(), sent.end(), cemi.begin(), cemi.end()); };
  const auto found = std::find_if(sent_.begin(), sent_.end(), same);
  if (found == sent_.end()) return false;
  sent_.erase(found);
  return true;
}

/// The telegram is still delivered: it may be a valid answer (knx.md, 6.4).
void Routing::check_source_address(const Endpoint& from, ByteView cemi) {
  const auto frame = wire::read_data_frame(cemi);
  if (!frame || frame->source != options_.address) return;
  ++counters_.duplicate_address;
  if (!address_rival_.empty()) return;
  address_rival_ = transport::to_string(from);
  callbacks_.changed();
}

void Routing::receive_busy(const Endpoint& from, const wire::RoutingBusy& busy) {
  ++counters_.busy;
  busy_rule_.receive(scheduler_.now(), std::chrono::milliseconds(busy.wait));
  if (!up_) return;
  wake_.set_at(busy_rule_.resume_at());
  if (!busy_router_.empty()) return;
  busy_router_ = transport::to_string(from);
  callbacks_.changed();
}

std::string Routing::problem() const {
  std::string text;
  if (!busy_router_.empty()) text = fmt::format("{} is busy: sending is paused", busy_router_);
  if (address_rival_.empty()) return text;
  return fmt::format("{}{}{} is also the address of {}", text, text.empty() ? "" : "; ", to_string(options_.address),
                     address_rival_);
}

std::map<std::string, std::uint64_t> Routing::counters() const {
  const auto& telegrams = telegrams_.counters();
  std::map<std::string, std::uint64_t> all{{"telegrams-sent", counters_.sent},
                                           {"telegrams-received", counters_.received},
                                           {"own-frames", counters_.own},
                                           {"bad-frames", counters_.bad},
                                           {"other-frames", counters_.other},
                                           {"busy", counters_.busy},
                                           {"lost-messages", counters_.lost},
                                           {"doubled-address", counters_.duplicate_address},
                                           {"send-retries", counters_.retries},
                                           {"telegrams-waiting", telegrams_.waiting()},
                                           {"telegrams-refused", telegrams.refused},
                                           {"telegrams-expired", telegrams.expired},
                                           {"telegrams-lost", telegrams.lost}};
  if (options_.guard != nullptr) all.merge(options_.guard->counters());
  return all;
}

}  // namespace rubicon::networks::knx::line
