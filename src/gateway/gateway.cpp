#include "gateway/gateway.h"

#include <fmt/format.h>

#include <deque>
#include <map>

#include "base/assert.h"
#include "base/rate_limit.h"
#include "gateway/foreign_requests.h"
#include "gateway/inbox.h"
#include "gateway/listeners.h"
#include "gateway/seen_messages.h"
#include "model/message_cbor.h"

namespace rubicon::gateway {

namespace {

constexpr std::string_view kGatewayKey = "GATEWAY";

model::Outcome outcome_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kUnsupported: return model::Outcome::kUnsupported;
    case ErrorCode::kRefused:
    case ErrorCode::kInvalid:
    case ErrorCode::kOutOfRange: return model::Outcome::kRefused;
    case ErrorCode::kBusy: return model::Outcome::kBusy;
    case ErrorCode::kNotFound:
    case ErrorCode::kUnreachable: return model::Outcome::kUndeliverable;
    default: return model::Outcome::kFailed;
  }
}

}  // namespace

struct Gateway::Parts {
  Parts(Scheduler& a_scheduler, TupleSpace& a_space, base::LogSink& sink, GatewayLimits some_limits)
      : scheduler(a_scheduler), space(a_space), log(sink, "gateway"), limits(some_limits) {
    // Numbers stay unique over restarts: microseconds since 1970, with room for 1024 messages in each.
    last_number = static_cast<std::uint64_t>(scheduler.wall_now().time_since_epoch().count()) << 10;
  }

  Scheduler& scheduler;
  TupleSpace& space;
  Log log;
  GatewayLimits limits;
  network::Supervisor* networks = nullptr;
  Listeners listeners;
  std::map<std::string, Inbox> inboxes;
  std::pair<const std::string, Inbox>* last_inbox = nullptr;
  std::deque<Message> outbox;   ///< sent here, or arrived from another island; not yet routed
  std::deque<Message> answers;  ///< of the gateway itself; as many as there were messages to answer
  SeenMessages seen;
  ForeignRequests foreign;
  Counters counters;
  base::RateLimit log_limit;
  std::uint64_t last_number = 0;
  std::shared_ptr<bool> asked = std::make_shared<bool>(false);  ///< a drain is posted
  Handle judge;

  OwnerId self() const { return space.self(); }
  Inbox& inbox(const std::string& network);
  void stamp(Message& message);
  void ask();
  void drain();
  void route(Message& message);
  void to_network(Message& message);
  void to_island(Message& message);
  void acknowledged(Message& message);
  void answer(const Message& message, model::Outcome outcome, std::string text);
  tuples::Judgement arrived(const tuples::RemoteSet& wish);
};

Inbox& Gateway::Parts::inbox(const std::string& network) {
  if (last_inbox && last_inbox->first == network) return last_inbox->second;
  last_inbox = &*inboxes.try_emplace(network, limits).first;
  return last_inbox->second;
}

void Gateway::Parts::stamp(Message& message) {
  if (message.origin == model::kNobody) {
    message.origin = self();
    message.number = ++last_number;
    message.hops = 0;
  }
}

void Gateway::Parts::ask() {
  if (std::exchange(*asked, true)) return;
  scheduler.post([this, alive = std::weak_ptr(asked)] {
    if (!alive.expired()) drain();
  });
}

void Gateway::Parts::drain() {
  *asked = false;
  Message message;
  for (auto& [network, inbox] : inboxes) {
    while (inbox.take(message)) {
      ++inbox.counters.delivered;
      route(message);
    }
  }
  for (auto count = outbox.size(); count > 0; --count) {
    message = std::move(outbox.front());
    outbox.pop_front();
    route(message);
  }
  for (auto count = answers.size(); count > 0; --count) {
    message = std::move(answers.front());
    answers.pop_front();
    route(message);
  }
}

void Gateway::Parts::route(Message& message) {
  ++counters.delivered;
  if (message.destination.island != self()) return to_island(message);
  if (message.kind() == MessageKind::kAcknowledge) return acknowledged(message);
  if (!message.destination.network.empty()) return to_network(message);
  const bool heard = listeners.tell(message);
  if (heard || message.kind() != MessageKind::kOpaque) return;
  const auto& type = std::get<model::Opaque>(message.body).type;
  answer(message, model::Outcome::kUndeliverable, fmt::format("nobody on this island listens to '{}'", type));
}

void Gateway::Parts::acknowledged(Message& message) {
  auto& acknowledge = std::get<model::Acknowledge>(message.body);
  if (auto asker = foreign.asker(acknowledge.request)) {
    acknowledge.request = asker->request;
    message.destination = std::move(asker->address);
    return to_island(message);
  }
  listeners.tell(message);
}

void Gateway::Parts::to_network(Message& message) {
  if (!networks) {
    return answer(message, model::Outcome::kUndeliverable, "this island has no networks");
  }
  if (message.source.island != self()) foreign.translate(message);
  auto sent = networks->send(message);
  if (sent) return;
  answer(message, outcome_of(sent.error().code), std::move(sent.error().text));
}

void Gateway::Parts::to_island(Message& message) {
  const auto island = message.destination.island;
  if (message.hops >= model::kMaxHops) {
    ++counters.looped;
    return answer(message, model::Outcome::kUndeliverable,
                  fmt::format("hop limit: entered {} islands already", message.hops));
  }
  const auto form = model::to_cbor(message);
  tuples::SetOptions options;
  options.media_type = model::kMessageMediaType;
  seen.first(message.origin, message.number);
  space.set_remote(island, kGatewayKey, base::as_text(form), {},
                   [this, alive = std::weak_ptr(asked), message](const tuples::Reply& reply) {
                     if (alive.expired() || reply.verdict == tuples::Verdict::kApplied) return;
                     const auto outcome = reply.verdict == tuples::Verdict::kRefused ? outcome_of(reply.code)
                                                                                     : model::Outcome::kUndeliverable;
                     answer(message, outcome,
                            fmt::format("island {}: {} {}", number(message.destination.island),
                                        to_string(reply.verdict), reply.text));
                   },
                   options);
}

void Gateway::Parts::answer(const Message& message, model::Outcome outcome, std::string text) {
  ++counters.undeliverable;
  if (message.kind() == MessageKind::kAcknowledge) return;
  Message reply;
  stamp(reply);
  reply.source = message.destination;
  reply.source.island = self();
  reply.destination = message.source;
  reply.body = model::Acknowledge{request_of(message), outcome, std::move(text)};
  answers.push_back(std::move(reply));
  ask();
}

tuples::Judgement Gateway::Parts::arrived(const tuples::RemoteSet& wish) {
  const auto refuse = [this, &wish](ErrorCode code, std::string why) {
    ++counters.malformed;
    if (log_limit.allow(fmt::format("{}", number(wish.from)), scheduler.now())) {
      log.warning(fmt::format("message from {} refused: {}", number(wish.from), why));
    }
    return tuples::Judgement::refused({code, std::move(why)});
  };
  if (!model::is_message_media_type(wish.media_type)) {
    return refuse(ErrorCode::kInvalid, fmt::format("GATEWAY: media type {} is not {}", model::quoted(wish.media_type),
                                                   model::kMessageMediaType));
  }
  auto message = model::from_cbor(base::as_bytes(wish.value));
  if (!message) return refuse(message.error().code, "GATEWAY: " + message.error().text);
  if (outbox.size() >= limits.queue) {
    ++counters.refused_busy;
    return tuples::Judgement::refused({ErrorCode::kBusy, "GATEWAY: too many messages waiting on this island"});
  }
  if (message->origin == model::kNobody) {  // a plain component need not number its messages
    message->source.island = wish.from;
    stamp(*message);
    message->origin = wish.from;
  } else if (message->origin == self() || !seen.first(message->origin, message->number)) {
    ++(message->origin == self() ? counters.looped : counters.duplicates);
    return tuples::Judgement::consumed();
  }
  if (message->destination.island == model::kNobody) message->destination.island = self();
  ++message->hops;
  outbox.push_back(std::move(*message));
  ask();
  return tuples::Judgement::consumed();
}

Gateway::Gateway(Scheduler& scheduler, TupleSpace& space, base::LogSink& log, GatewayLimits limits)
    : parts_(std::make_unique<Parts>(scheduler, space, log, limits)) {
  parts_->judge = space.judge({space.self(), std::string(kGatewayKey)},
                              [parts = parts_.get()](const auto& wish) { return parts->arrived(wish); });
  tuples::SetOptions options;
  options.media_type = model::kMessageMediaType;
  RUBICON_ASSERT(space.declare(kGatewayKey, {}, options).has_value());
}

Gateway::~Gateway() = default;

void Gateway::connect(network::Supervisor& networks) { parts_->networks = &networks; }

Handle Gateway::subscribe(MessageKind kind, MessageCall call) {
  return parts_->listeners.subscribe(kind, std::move(call));
}

Handle Gateway::subscribe_user(std::string_view type, MessageCall call) {
  return parts_->listeners.subscribe_user(type, std::move(call));
}

void Gateway::send(Message message) {
  RUBICON_DEBUG_ASSERT(parts_->scheduler.on_loop_thread());
  parts_->stamp(message);
  if (message.source.island == model::kNobody) message.source.island = parts_->self();
  if (parts_->outbox.size() >= parts_->limits.queue) {
    ++parts_->counters.refused_busy;
    return parts_->answer(message, model::Outcome::kBusy, "too many messages waiting");
  }
  parts_->outbox.push_back(std::move(message));
  parts_->ask();
}

void Gateway::from_network(const std::string& network, Message message) {
  RUBICON_DEBUG_ASSERT(parts_->scheduler.on_loop_thread());
  parts_->stamp(message);
  auto& inbox = parts_->inbox(network);
  if (!inbox.put(message)) parts_->answer(message, model::Outcome::kBusy, "too many messages waiting");
  parts_->ask();
}

Gateway::Counters Gateway::counters() const { return parts_->counters; }

Gateway::Counters Gateway::counters(const std::string& network) const {
  const auto found = parts_->inboxes.find(network);
  return found == parts_->inboxes.end() ? Counters{} : found->second.counters;
}

}  // namespace rubicon::gateway
