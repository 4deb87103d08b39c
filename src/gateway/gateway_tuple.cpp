#include "gateway/gateway_tuple.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <random>
#include <utility>

#include "base/assert.h"
#include "model/message.h"

namespace rubicon::gateway {

namespace {

__extension__ using Wide = unsigned __int128;
constexpr std::uint64_t kPrime = (std::uint64_t{1} << 61) - 1;

/// A number below kPrime.
std::uint64_t make_secret() {
  std::random_device source;
  return ((std::uint64_t{source()} << 32) | source()) % kPrime;
}

}  // namespace

SeenMessages::SeenMessages() : secret_(make_secret()) {}

/// A polynomial of the bytes at a secret point: two texts of n bytes have the same value at no more than n points.
std::uint64_t SeenMessages::place_of(const Address& to) const {
  std::uint64_t value = 1;
  const auto add = [&](std::uint64_t next) {
    value = static_cast<std::uint64_t>((Wide{value} * secret_ + next) % kPrime);
  };
  add(number(to.island));
  for (const auto* name : {&to.network, &to.device}) {
    for (const char byte : *name) add(static_cast<unsigned char>(byte) + 1U);
    add(0);  // the end of a name
  }
  return value;
}

bool SeenMessages::seen(const Address& to, IslandId origin, std::uint64_t number) const {
  const auto found = windows_.find(origin);
  if (found == windows_.end() || number > found->second.highest) return false;
  const auto& numbers = found->second.numbers;
  return std::find(numbers.begin(), numbers.end(), Seen{number, place_of(to)}) != numbers.end();
}

void SeenMessages::note(const Address& to, IslandId origin, std::uint64_t number) {
  Window& known = window(origin);
  known.highest = std::max(known.highest, number);
  if (known.numbers.size() < kNumbers) {
    known.numbers.push_back({number, place_of(to)});
    return;
  }
  known.numbers[known.next] = {number, place_of(to)};
  known.next = (known.next + 1) % kNumbers;
}

SeenMessages::Window& SeenMessages::window(IslandId origin) {
  if (const auto found = windows_.find(origin); found != windows_.end()) {
    by_age_.splice(by_age_.begin(), by_age_, found->second.age);
    return found->second;
  }
  if (windows_.size() >= kOrigins) {
    windows_.erase(by_age_.back());
    by_age_.pop_back();
  }
  by_age_.push_front(origin);
  Window& fresh = windows_[origin];
  fresh.age = by_age_.begin();
  return fresh;
}

namespace {

constexpr std::string_view kKey = "GATEWAY";
constexpr std::array<std::string_view, 2> kOriginalKeys{"RUBICON_GATEWAY", "RUBICON_GATEWAY.*"};

/// STREAM_MAGIC and STREAM_VERSION of the Java Object Serialization Specification, section 6.4.2.
constexpr std::string_view kJavaStream("\xac\xed\x00\x05", 4);

/// A message that has passed no island yet must name its sender as origin and source; only islands forward messages.
Result<void> check_sender(const Message& message, OwnerId from) {
  const auto forged = [from](std::string_view what, const std::string& claimed) {
    return fail(ErrorCode::kRefused, fmt::format("{} {}, but component {} posted it", what, claimed, number(from)));
  };
  if (message.hops > 0) {
    return model::is_island(from) ? Result<void>{} : forged("hops", std::to_string(unsigned{message.hops}));
  }
  const auto& source = message.source.island;
  if (message.origin != model::kNoOwner && message.origin != from)
    return forged("origin", std::to_string(number(message.origin)));
  if (source != model::kNoOwner && source != from) return forged("source", to_string(message.source));
  return {};
}

}  // namespace

std::uint64_t answerable_number(const Message& message) {
  if (const auto* actuate = std::get_if<model::Actuate>(&message.body)) return actuate->request;
  if (const auto* sample = std::get_if<model::Sample>(&message.body)) return sample->request;
  if (const auto* set = std::get_if<model::SetProperty>(&message.body)) return set->request;
  return message.number;
}

Envelope::Envelope(const Message& message)
    : source(message.source),
      destination(message.destination),
      number(answerable_number(message)),
      answerable(message.kind() != MessageKind::kAcknowledge) {}

GatewayTuple::GatewayTuple(TupleSpace& space, const MessageRights& rights, const GatewayLimits& limits, Arrival arrival,
                           Failure failure, Forged forged, Foreign foreign)
    : space_(space),
      rights_(rights),
      limit_(limits.queue),
      arrival_(std::move(arrival)),
      failure_(std::move(failure)),
      forged_(std::move(forged)),
      foreign_(std::move(foreign)) {
  RUBICON_ASSERT(space_.declare(kKey));
  accept(kKey);
  for (const auto key : kOriginalKeys) accept(key);
}

void GatewayTuple::accept(std::string_view key) {
  policies_.push_back(space_.add_policy({space_.self(), std::string(key)},
                                        [this](const tuples::RemoteSet& request) { return receive(request); }));
}

GatewayTuple::~GatewayTuple() {
  policies_.clear();
  static_cast<void>(space_.erase(kKey));
}

Result<void> GatewayTuple::send(const Message& message) {
  const Envelope envelope(message);
  const IslandId to = message.destination.island;
  if (under_way_ >= limit_) {
    const std::string why = "too many messages to other islands are under way";
    failure_(envelope, model::Outcome::kBusy, why);
    return fail(ErrorCode::kBusy, why);
  }
  ++under_way_;
  const Bytes bytes = model::to_cbor(message);
  tuples::SetOptions options;
  options.media_type = model::kMessageMediaType;
  auto answer = lifetime_.guard([this, envelope](const tuples::Reply& reply) { answered(envelope, reply); });
  space_.set_remote(to, kKey, base::as_text(bytes), Duration(0), std::move(answer), options);
  const auto peers = space_.peers();
  if (std::find(peers.begin(), peers.end(), to) != peers.end()) return {};
  return fail(ErrorCode::kUnreachable, fmt::format("island {} is not there", number(to)));
}

void GatewayTuple::answered(const Envelope& envelope, const tuples::Reply& reply) {
  --under_way_;
  if (reply.verdict == tuples::Verdict::kApplied) {
    ++counters.delivered;
    if (accepted_) accepted_(envelope.number);
    return;
  }
  const bool busy = reply.verdict == tuples::Verdict::kRefused && reply.code == ErrorCode::kBusy;
  failure_(envelope, busy ? model::Outcome::kBusy : model::Outcome::kUndeliverable,
           fmt::format("island {}: {}{}{}", number(envelope.destination.island), to_string(reply.verdict),
                       reply.text.empty() ? "" : ": ", reply.text));
}

tuples::SetDecision GatewayTuple::malformed(Error why) {
  ++counters.malformed;
  return tuples::SetDecision::refused(std::move(why));
}

tuples::SetDecision GatewayTuple::forged(OwnerId from, Error why) {
  ++counters.forged;
  forged_(from, why.text);
  return tuples::SetDecision::refused(std::move(why));
}

bool GatewayTuple::is_repeated(const Message& message) {
  const bool repeated = message.number != 0 && seen_.seen(message.destination, message.origin, message.number);
  if (repeated) ++counters.duplicates;
  return repeated;
}

void GatewayTuple::note(const Message& message, const Address& to) {
  if (message.number != 0) seen_.note(to, message.origin, message.number);
}

tuples::SetDecision GatewayTuple::receive(const tuples::RemoteSet& request) {
  if (!model::is_message_media_type(request.media_type))
    return malformed({ErrorCode::kUnsupported, fmt::format("GATEWAY expects {}, got {}", model::kMessageMediaType,
                                                           model::quoted(request.media_type))});
  if (request.value.starts_with(kJavaStream)) {
    const std::string why = "messages in Java serialisation are not supported";
    foreign_(request.from, why);
    return malformed({ErrorCode::kUnsupported, why});
  }
  auto message = model::from_cbor(base::as_bytes(request.value));
  if (!message) return malformed(std::move(message.error()));
  if (auto own = check_sender(*message, request.from); !own) return forged(request.from, std::move(own.error()));
  auto relay = rights_.name_sender(request.from, *message);
  if (!relay) return forged(request.from, std::move(relay.error()));
  // A component that is not an island sends without origin and number: its duplicates cannot be recognised.
  if (message->origin == model::kNoOwner) {
    message->origin = request.from;
    message->number = 0;
  } else if (message->origin == space_.self()) {
    ++counters.looped;
    return tuples::SetDecision::consumed();
  }
  if (message->destination.island == model::kNoOwner) message->destination.island = space_.self();
  if (is_repeated(*message)) return tuples::SetDecision::consumed();
  if (message->hops >= model::kMaxHops) {
    ++counters.looped;
    return tuples::SetDecision::refused(
        {ErrorCode::kRefused, fmt::format("hop limit of {} reached", unsigned{model::kMaxHops})});
  }
  ++message->hops;
  if (message->source.island == model::kNoOwner) message->source.island = request.from;
  if (auto taken = arrival_(std::move(*message), std::move(*relay), request.value.size()); !taken)
    return tuples::SetDecision::refused(std::move(taken.error()));
  return tuples::SetDecision::consumed();
}

}  // namespace rubicon::gateway
