#include "networks/knx/line/routing.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "networks/knx/wire/cemi.h"

namespace rubicon::networks::knx::line {

namespace {

/// Of own frames, to know them when they come back (as Calimero keeps them).
constexpr std::size_t kRemembered = 20;
/// A system that has no room for a datagram so often has none at all.
constexpr unsigned kMostAttempts = 50;

}  // namespace

Routing::Routing(Scheduler& scheduler, Options options, Calls calls)
    : scheduler_(scheduler),
      options_(options),
      calls_(std::move(calls)),
      outbox_(scheduler, options.limits, [this] { pump(); }),
      busy_(options.seed),
      wake_(scheduler, [this] { pump(); }) {}

Routing::~Routing() {
  *alive_ = false;
}

void Routing::up(Endpoint own) {
  own_ = std::move(own);
  up_ = true;
  wake_.set(Duration::zero());
}

void Routing::down() {
  if (!std::exchange(up_, false)) return;
  outbox_.line_lost();
  attempts_ = 0;
  sent_.clear();
}

void Routing::send(wire::Telegram telegram, SteadyTime expires, SentCall done) {
  telegram.source = options_.address;
  outbox_.push(std::move(telegram), expires, std::move(done));
}

/// True while a router is busy or the last frame is too recent; pump() follows.
bool Routing::must_wait() {
  const auto now = scheduler_.now();
  const auto earliest = std::max(next_at_, busy_.resume_at());
  if (now < earliest) wake_.set_at(earliest);
  return now < earliest;
}

void Routing::pump() {
  if (!up_ || must_wait()) return;
  if (!busy_one_.empty()) {
    busy_one_.clear();
    wake_.set(Duration::zero());
    return calls_.changed();
  }
  if (outbox_.under_way()) return transmit();
  const auto* telegram = outbox_.take();
  if (telegram == nullptr) return;
  auto cemi = wire::write_telegram(wire::CemiCode::kDataIndication, *telegram);
  if (!cemi) {
    wake_.set(Duration::zero());
    return outbox_.finish(Sent::kRefused, cemi.error().text);
  }
  cemi_ = std::move(*cemi);
  frame_ = write(wire::Message(wire::RoutingIndication{cemi_}));
  transmit();
}

/// There is no confirmation in routing: that it left is all that is known.
void Routing::transmit() {
  const auto now = scheduler_.now();
  next_at_ = now + (busy_.slow(now) ? 2 * options_.gap : options_.gap);
  wake_.set_at(next_at_);
  const auto sent = calls_.send(frame_);
  if (!sent) {
    ++counters_.retries;
    if (sent.error().code != ErrorCode::kBusy || ++attempts_ >= kMostAttempts) give_up(sent.error());
    return;
  }
  attempts_ = 0;
  ++counters_.sent;
  sent_.push_back(cemi_);
  if (sent_.size() > kRemembered) sent_.pop_front();
  const auto alive = alive_;
  const auto cemi = std::exchange(cemi_, {});
  calls_.frame(cemi, true);
  if (*alive) outbox_.finish(Sent::kSent, "");
}

void Routing::give_up(Error why) {
  down();
  calls_.failed(std::move(why));
}

void Routing::heard(const Endpoint& from, ByteView datagram, Group group) {
  const auto message = wire::read_message(datagram);
  if (!message) {
    ++counters_.bad;
    return remark("bad-frames", from, fmt::format("sent a frame that cannot be read: {}", message.error().text));
  }
  if (const auto* routed = std::get_if<wire::RoutingIndication>(&*message)) return indication(from, *routed, group);
  if (std::holds_alternative<wire::SearchRequest>(*message) || std::holds_alternative<wire::SearchResponse>(*message))
    return calls_.discovery(from, datagram);
  if (group == Group::kSystem) return;
  if (const auto* said = std::get_if<wire::RoutingBusy>(&*message)) return busy(from, *said);
  if (const auto* said = std::get_if<wire::RoutingLostMessage>(&*message)) {
    counters_.lost += said->lost;
    const auto alive = alive_;
    remark("lost-messages", from,
           fmt::format("lost {} telegrams on their way (device state {:02x})", said->lost, said->device_state));
    if (*alive) calls_.lost(from, *said);
    return;
  }
  ++counters_.other;
  if (const auto* other = std::get_if<wire::OtherService>(&*message))
    remark("unknown-services", from, fmt::format("sent {}: passed over", to_string(other->service)));
}

void Routing::remark(const std::string& subject, const Endpoint& from, std::string_view what) {
  if (calls_.note) calls_.note(subject, fmt::format("{} {}", transport::to_string(from), what));
}

/// System broadcasts go over 224.0.23.12 only, all else over the routing group only; neither is for us but the monitor.
void Routing::indication(const Endpoint& from, const wire::RoutingIndication& indication, Group group) {
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
    return calls_.frame(indication.cemi, false);
  }
  const auto alive = alive_;
  calls_.frame(indication.cemi, false);
  if (!*alive) return;
  watch_address(from, indication.cemi);
  if (!*alive) return;
  const auto telegram = indication.system_broadcast
                            ? Result<wire::Telegram>(fail(ErrorCode::kUnsupported, "a broadcast"))
                            : wire::to_telegram(*frame);
  ++(telegram ? counters_.received : telegram.error().code == ErrorCode::kInvalid ? counters_.bad : counters_.other);
  if (telegram) calls_.received(*telegram);
}

/// Nobody else sends from our port; where the address it is seen with is unknown, another machine may.
bool Routing::is_own(const Endpoint& from, ByteView cemi) {
  if (from.port != own_.port) return false;
  if (!own_.address.empty()) return from.address == own_.address;
  const auto same = [&](const Bytes& sent) { return std::equal(sent.begin(), sent.end(), cemi.begin(), cemi.end()); };
  const auto found = std::find_if(sent_.begin(), sent_.end(), same);
  if (found == sent_.end()) return false;
  sent_.erase(found);
  return true;
}

/// Nothing is dropped for that: the bytes may be a true answer all the same (knx.md, 6.4).
void Routing::watch_address(const Endpoint& from, ByteView cemi) {
  const auto frame = wire::read_data_frame(cemi);
  if (!frame || frame->source != options_.address) return;
  ++counters_.doubled;
  if (!doubled_by_.empty()) return;
  doubled_by_ = transport::to_string(from);
  calls_.changed();
}

void Routing::busy(const Endpoint& from, const wire::RoutingBusy& busy) {
  ++counters_.busy;
  busy_.heard(scheduler_.now(), std::chrono::milliseconds(busy.wait));
  if (!up_) return;
  wake_.set_at(busy_.resume_at());
  if (!busy_one_.empty()) return;
  busy_one_ = transport::to_string(from);
  calls_.changed();
}

std::string Routing::note() const {
  std::string text;
  if (!busy_one_.empty()) text = fmt::format("{} is busy: nothing is sent for now", busy_one_);
  if (doubled_by_.empty()) return text;
  return fmt::format("{}{}{} is the address of {} too", text, text.empty() ? "" : "; ", to_string(options_.address),
                     doubled_by_);
}

std::map<std::string, std::uint64_t> Routing::counters() const {
  const auto& box = outbox_.counters();
  return {{"telegrams-sent", counters_.sent},  {"telegrams-received", counters_.received},
          {"own-frames", counters_.own},       {"bad-frames", counters_.bad},
          {"other-frames", counters_.other},   {"busy", counters_.busy},
          {"lost-messages", counters_.lost},   {"doubled-address", counters_.doubled},
          {"send-retries", counters_.retries}, {"telegrams-waiting", outbox_.waiting()},
          {"telegrams-refused", box.refused},  {"telegrams-expired", box.expired},
          {"telegrams-lost", box.lost}};
}

}  // namespace rubicon::networks::knx::line
