#include "gateway/gateway.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <map>
#include <utility>
#include <vector>

#include "base/assert.h"
#include "base/log.h"
#include "base/scheduler.h"
#include "gateway/gateway_tuple.h"
#include "gateway/message_rights.h"
#include "gateway/network_queue.h"
#include "gateway/questions.h"
#include "rubicon/key.hpp"

namespace rubicon::gateway {

using model::Outcome;

namespace {

/// Bytes from other islands that may wait for the next turn.
constexpr std::size_t kForeignBytes = 16 << 20;

Outcome outcome_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kUnsupported: return Outcome::kUnsupported;
    case ErrorCode::kInvalid:
    case ErrorCode::kOutOfRange:
    case ErrorCode::kRefused: return Outcome::kRefused;
    case ErrorCode::kBusy: return Outcome::kBusy;
    case ErrorCode::kNotFound:
    case ErrorCode::kUnreachable: return Outcome::kUndeliverable;
    default: return Outcome::kFailed;
  }
}

/// Requests and application messages without a listener are answered; reports need none.
bool requires_listener(MessageKind kind) {
  return kind == MessageKind::kOpaque || kind == MessageKind::kActuate || kind == MessageKind::kSample ||
         kind == MessageKind::kSetProperty || kind == MessageKind::kProbe;
}

bool is_command(MessageKind kind) {
  return kind == MessageKind::kActuate || kind == MessageKind::kSetProperty;
}

/// Answers need no right: who asked waits for them.
bool is_answer(const Message& message) {
  return message.kind() == MessageKind::kAcknowledge;
}

/// Every component may pass on an answer, with any origin and number.
bool may_be_noted(const Message& message) {
  return !is_answer(message) || message.hops <= 1;
}

void add(Gateway::Counters& sum, const Gateway::Counters& part) {
  sum.delivered += part.delivered;
  sum.dropped_readings += part.dropped_readings;
  sum.refused_busy += part.refused_busy;
  sum.undeliverable += part.undeliverable;
  sum.duplicates += part.duplicates;
  sum.looped += part.looped;
  sum.malformed += part.malformed;
  sum.forged += part.forged;
  sum.not_permitted += part.not_permitted;
}

}  // namespace

struct Gateway::Impl {
  struct Foreign {
    Message message;
    Relay relay;
  };
  Impl(Scheduler& s, TupleSpace& space, base::LogSink& sink, GatewayLimits l)
      : scheduler(s),
        self(space.self()),
        log(Log(sink, "gateway"), s),
        limits(l),
        last_number(static_cast<std::uint64_t>(s.wall_now().time_since_epoch().count()) << 10),
        rights(space),
        next_turn(s, [this] { turn(); }),
        gateway_tuple(
            space, rights, limits,
            [this](Message message, Relay relay, std::size_t size) {
              return on_arrival({std::move(message), std::move(relay)}, size);
            },
            [this](const Envelope& envelope, Outcome outcome, std::string why) {
              undelivered(envelope, outcome, std::move(why));
            },
            [this](OwnerId from, const std::string& why) {
              log.warning("forged", fmt::format("refused a message of component {}: {}", number(from), why));
            },
            [this](OwnerId from, const std::string& why) {
              log.warning("foreign", fmt::format("refused a message of component {}: {}", number(from), why));
            }) {}

  NetworkQueue& queue_of(const std::string& network);
  Result<void> on_arrival(Foreign message, std::size_t size);
  std::uint64_t send(Message message);
  void stamp(Message& message);
  void turn();
  /// Counts and answers.
  void undelivered(const Envelope& envelope, Outcome outcome, std::string why);
  void answer(const Envelope& envelope, Outcome outcome, std::string why);
  void report_drops(NetworkQueue& queue);
  void refuse(NetworkQueue& queue, const Message& message);

  /// True: the rights allowed the message, so later ones with its origin and number count as repeated.
  bool route(Message& message, Counters& count);
  bool to_listeners(const Message& message, Counters& count);
  /// `found`: the message did not name the network.
  bool to_network(Message& message, Counters& count, bool found = false);
  void refuse_ambiguous(Message& message, const std::vector<std::string>& found);
  void not_taken(Message& message, Error why, bool hide);
  Result<void> to_own_network(const Message& message);
  Error nobody_hears(const Message& message) const;
  bool is_ours(const Message& message) const;
  /// False: its sender may not send it there, and was answered.
  bool permits(const Message& message, std::string_view where);
  Places places_of(const Address& to) const;
  bool names_only_a_device(const Message& message) const;
  bool to_device(Message& message, Counters& count);
  bool may_reach(Message& message, const std::string& network) const;

  Scheduler& scheduler;
  IslandId self;
  base::LimitedLog log;
  GatewayLimits limits;
  network::Supervisor* networks = nullptr;
  NetworksOf networks_of;
  PartsOf parts_of;
  NextCall look_ahead;
  CommandCall handle_command;
  MayCommand may_command;
  std::uint64_t last_number;  ///< starts at the wall clock, so that numbers are unique over restarts
  std::map<std::string, NetworkQueue> queues;
  NetworkQueue* last_queue = nullptr;
  std::vector<Foreign> foreign;  ///< from other processes
  std::vector<Message> outbox;   ///< from own components
  Relay relay;                   ///< of the message that is on its way through route()
  std::size_t foreign_bytes = 0;
  std::array<Listeners, std::variant_size_v<model::Body>> listeners;
  std::map<std::string, Listeners, std::less<>> user_listeners;
  Counters own;
  MessageRights rights;
  base::OncePerTurn next_turn;
  GatewayTuple gateway_tuple;
};

NetworkQueue& Gateway::Impl::queue_of(const std::string& network) {
  if (last_queue == nullptr || last_queue->network() != network)
    last_queue = &queues.try_emplace(network, network, limits).first->second;
  return *last_queue;
}

void Gateway::Impl::stamp(Message& message) {
  if (message.origin != model::kNoOwner) return;
  message.origin = self;
  message.number = ++last_number;
}

/// Routes all waiting messages, but none that arrive meanwhile.
void Gateway::Impl::turn() {
  auto from_islands = std::exchange(foreign, {});
  auto from_components = std::exchange(outbox, {});
  foreign_bytes = 0;
  for (auto& [network, queue] : queues) {
    queue.drain(look_ahead, [&, count = &queue.counters](Message& message) { route(message, *count); });
    report_drops(queue);
  }
  for (auto& one : from_islands) {
    relay = std::move(one.relay);
    const auto to = one.message.destination;  // as it came
    // A refused sender must not use up the numbers of others.
    if (!gateway_tuple.is_repeated(one.message) && route(one.message, own)) gateway_tuple.note(one.message, to);
  }
  relay.reset();
  for (Message& message : from_components) route(message, own);
}

Result<void> Gateway::Impl::on_arrival(Foreign message, std::size_t size) {
  if (foreign.size() >= limits.queue || foreign_bytes + size > kForeignBytes) {
    ++own.refused_busy;
    return fail(ErrorCode::kBusy, "too many messages are waiting at this gateway");
  }
  foreign_bytes += size;
  foreign.push_back(std::move(message));
  next_turn.request();
  return {};
}

std::uint64_t Gateway::Impl::send(Message message) {
  stamp(message);
  const auto number = answerable_number(message);
  if (message.source.island == model::kNoOwner) message.source.island = self;
  if (message.destination.island == model::kNoOwner) message.destination.island = self;
  if (outbox.size() >= limits.queue) {
    undelivered(Envelope(message), Outcome::kBusy, "too many messages are waiting at this gateway");
    return number;
  }
  outbox.push_back(std::move(message));
  next_turn.request();
  return number;
}

void Gateway::Impl::undelivered(const Envelope& envelope, Outcome outcome, std::string why) {
  if (outcome == Outcome::kBusy) ++own.refused_busy;
  if (outcome == Outcome::kUndeliverable) {
    ++own.undeliverable;
    const auto to = to_string(envelope.destination);
    log.debug("undeliverable " + to,
              fmt::format("undeliverable from {} to {}: {}", to_string(envelope.source), to, why));
  }
  answer(envelope, outcome, std::move(why));
}

/// Answers may use twice the room of other messages.
void Gateway::Impl::answer(const Envelope& envelope, Outcome outcome, std::string why) {
  if (!envelope.answerable || outbox.size() >= limits.queue * 2) return;
  Message answer;
  answer.source = envelope.destination;
  answer.source.island = self;  // also if the message was for another island
  answer.destination = envelope.source;
  answer.body = model::Acknowledge{envelope.number, outcome, std::move(why)};
  stamp(answer);
  outbox.push_back(std::move(answer));
  next_turn.request();
}

void Gateway::Impl::report_drops(NetworkQueue& queue) {
  const auto dropped = queue.counters.dropped_readings;
  if (dropped == queue.reported_drops) return;
  const auto text =
      fmt::format("network {}: {} readings dropped so far because more than {} were waiting, or {} MiB of text",
                  queue.network(), dropped, limits.queue, NetworkQueue::kMaxBytes >> 20);
  if (log.warning(queue.network() + " drops", text)) queue.reported_drops = dropped;
}

void Gateway::Impl::refuse(NetworkQueue& queue, const Message& message) {
  ++queue.counters.refused_busy;
  auto why = fmt::format("too many messages of network {} are waiting", queue.network());
  log.warning(queue.network(), why);
  if (message.kind() == MessageKind::kOpaque) answer(Envelope(message), Outcome::kBusy, std::move(why));
}

bool Gateway::Impl::route(Message& message, Counters& count) {
  const auto to = message.destination.island;
  if (to != self) {
    const auto where = fmt::format("island:{}", number(to));
    if (!is_answer(message) && !permits(message, where)) return false;
    const auto handed_on = gateway_tuple.send(message);
    if (!is_answer(message)) rights.record(message, relay, where, handed_on);
    return may_be_noted(message);
  }
  if (names_only_a_device(message)) return to_device(message, count);
  // Networks accept no Acknowledge: an answer to a device goes to the listeners.
  if (message.destination.network.empty() || is_answer(message)) return to_listeners(message, count);
  return to_network(message, count);
}

bool Gateway::Impl::names_only_a_device(const Message& message) const {
  const auto& to = message.destination;
  return networks_of && to.network.empty() && !to.device.empty() && requires_listener(message.kind());
}

bool Gateway::Impl::permits(const Message& message, std::string_view where) {
  if (!message.sender) return true;
  auto answer = rights.may_send(message, relay, {std::string(where)});
  if (answer) return true;
  ++own.not_permitted;
  undelivered(Envelope(message), Outcome::kRefused, std::move(answer.error().text));
  return false;
}

Places Gateway::Impl::places_of(const Address& to) const {
  Places places{place_of(to)};
  auto parts = parts_of && !to.device.empty() ? parts_of(to.network, to.device) : std::string();
  if (!parts.empty() && parts != places.front()) places.push_back(std::move(parts));
  return places;
}

/// A mote's message to a mote of another island names no network (wsn.md, section 9.8).
bool Gateway::Impl::to_device(Message& message, Counters& count) {
  auto& to = message.destination;
  auto found = networks_of(to.device);
  if (found.empty()) return to_listeners(message, count);
  auto first = found.front();
  // Networks that its sender may not reach do not exist for it. If none is left, the first one refuses for all.
  if (found.size() > 1) std::erase_if(found, [&](const auto& network) { return !may_reach(message, network); });
  if (found.size() > 1) {
    refuse_ambiguous(message, found);
    return false;
  }
  to.network = std::move(found.empty() ? first : found.front());
  return to_network(message, count, true);
}

/// Whether its sender may do there what it asks for: `send`, or of a command `set`. A question, which is not counted.
bool Gateway::Impl::may_reach(Message& message, const std::string& network) const {
  auto& to = message.destination;
  to.network = network;
  const auto where = places_of(to);
  const bool may = is_command(message.kind())
                       ? rights.is_believed(relay, where) && (!may_command || may_command(message))
                       : rights.ask(message, relay, where).has_value();
  to.network.clear();
  return may;
}

/// `found`: those that its sender may reach.
void Gateway::Impl::refuse_ambiguous(Message& message, const std::vector<std::string>& found) {
  Error why{ErrorCode::kRefused,
            fmt::format("device {} is in {} networks of island {} ({}): name one",
                        model::quoted(message.destination.device), found.size(), number(self), fmt::join(found, ", "))};
  rights.record(message, relay, kOwn, fail(why));
  not_taken(message, std::move(why), false);
}

/// `hide`: the answer is the one for a device that does not exist, because its sender may not know of this one.
void Gateway::Impl::not_taken(Message& message, Error why, bool hide) {
  if (hide) {
    message.destination.network.clear();
    auto may = rights.ask(message, relay, {std::string(kOwn)});
    why = may ? nobody_hears(message) : std::move(may.error());
  }
  undelivered(Envelope(message), outcome_of(why.code), std::move(why.text));
}

bool Gateway::Impl::to_listeners(const Message& message, Counters& count) {
  const auto* opaque = std::get_if<model::Opaque>(&message.body);
  const bool asks_history = opaque && opaque->type == kHistoryQuestion;
  // Whoever answers it judges `read` of its sender, and of nobody who hands it on.
  const bool is_question =
      asks_history && !relay && message.destination.network.empty() && message.destination.device.empty();
  if (!is_answer(message) && !is_question && !permits(message, kOwn)) return false;
  if (asks_history && relay) {
    undelivered(Envelope(message), Outcome::kRefused, "questions about the past are not handed on: ask this island");
    return may_be_noted(message);
  }
  std::size_t calls = is_question ? 0 : listeners[message.body.index()].call(message);
  if (opaque) {
    const auto user = user_listeners.find(opaque->type);
    if (user != user_listeners.end()) calls += user->second.call(message);
  }
  const bool heard = calls > 0 || !requires_listener(message.kind());
  const auto taken = heard ? Result<void>() : fail(nobody_hears(message));
  if (!is_answer(message) && !is_question) rights.record(message, relay, kOwn, taken);
  if (taken) {
    ++count.delivered;
  } else {
    undelivered(Envelope(message), Outcome::kUndeliverable, taken.error().text);
  }
  return may_be_noted(message);
}

Error Gateway::Impl::nobody_hears(const Message& message) const {
  const auto* opaque = std::get_if<model::Opaque>(&message.body);
  const auto what = opaque ? model::quoted(opaque->type) : std::string(to_string(message.kind()));
  const auto& device = message.destination.device;
  return {ErrorCode::kNotFound,
          device.empty() ? fmt::format("island {} has no listener for {} messages", number(self), what)
                         : fmt::format("no network of island {} has a device {}", number(self), model::quoted(device))};
}

/// Commands need the right `set` of their sender, which the command desk judges.
bool Gateway::Impl::to_network(Message& message, Counters& count, bool found) {
  const auto where = message.sender ? places_of(message.destination) : Places{place_of(message.destination)};
  const bool may_hide = found && message.sender;
  auto may =
      is_command(message.kind()) ? rights.may_relay(message, relay, where) : rights.may_send(message, relay, where);
  if (!may) {
    ++own.not_permitted;
    not_taken(message, std::move(may.error()), may_hide);
    return false;
  }
  auto sent = to_own_network(message);
  if (!is_command(message.kind())) rights.record(message, relay, where.front(), sent);
  if (sent) {
    ++count.delivered;
    return true;
  }
  const auto code = sent.error().code;
  const bool hide = may_hide && sent.error().text == may_not_set(message).text;
  not_taken(message, std::move(sent.error()), hide);
  return !is_command(message.kind()) || code == ErrorCode::kBusy;
}

/// Components of this island may send anything; others only what docs/decisions/015 allows.
Result<void> Gateway::Impl::to_own_network(const Message& message) {
  if (networks == nullptr) return fail(ErrorCode::kNotFound, "this island has no networks");
  const auto kind = message.kind();
  if (is_ours(message) || kind == MessageKind::kOpaque) return networks->send(message);
  if (is_command(kind) && handle_command) return handle_command(message, relay ? relay->name : std::string());
  return fail(
      ErrorCode::kRefused,
      fmt::format("networks accept no {} of others: subscribe to tuples and set them instead", to_string(kind)));
}

bool Gateway::Impl::is_ours(const Message& message) const {
  return message.origin == self && message.source.island == self && message.source.network.empty();
}

Gateway::Gateway(Scheduler& scheduler, TupleSpace& space, base::LogSink& log, GatewayLimits limits)
    : impl_(std::make_unique<Impl>(scheduler, space, log, limits)) {}

Gateway::~Gateway() = default;

void Gateway::limit(GatewayLimits limits) {
  impl_->limits = limits;
  for (auto& [network, queue] : impl_->queues) queue.limit(limits);
}

void Gateway::forget(const std::string& network) {
  const auto queue = impl_->queues.find(network);
  if (queue == impl_->queues.end()) return;
  add(impl_->own, queue->second.counters);  // the island's sums never shrink
  impl_->last_queue = nullptr;
  impl_->queues.erase(queue);
}

void Gateway::set_device_lookup(NetworksOf networks_of, PartsOf parts_of) {
  impl_->networks_of = std::move(networks_of);
  impl_->parts_of = std::move(parts_of);
}

void Gateway::set_look_ahead(NextCall call) {
  impl_->look_ahead = std::move(call);
}

void Gateway::set_command_handler(CommandCall call, MayCommand may) {
  impl_->handle_command = std::move(call);
  impl_->may_command = std::move(may);
}

void Gateway::connect(network::Supervisor& networks) {
  impl_->networks = &networks;
}

Handle Gateway::subscribe(MessageKind kind, MessageCall call) {
  return impl_->listeners[static_cast<std::size_t>(kind)].add(std::move(call));
}

Handle Gateway::subscribe_user(std::string_view type, MessageCall call) {
  std::erase_if(impl_->user_listeners, [](const auto& one) { return one.second.empty(); });
  return impl_->user_listeners[std::string(type)].add(std::move(call));
}

std::uint64_t Gateway::send(Message message) {
  RUBICON_DEBUG_ASSERT(impl_->scheduler.on_loop_thread());
  return impl_->send(std::move(message));
}

void Gateway::on_accepted(std::function<void(std::uint64_t number)> call) {
  impl_->gateway_tuple.on_accepted(std::move(call));
}

void Gateway::from_network(const std::string& network, Message&& message) {
  RUBICON_DEBUG_ASSERT(impl_->scheduler.on_loop_thread());
  impl_->stamp(message);
  NetworkQueue& queue = impl_->queue_of(network);
  if (!queue.add(message)) impl_->refuse(queue, message);
  impl_->next_turn.request();
}

Gateway::Counters Gateway::counters() const {
  Counters sum = impl_->own;
  add(sum, impl_->gateway_tuple.counters);
  for (const auto& [network, queue] : impl_->queues) add(sum, queue.counters);
  return sum;
}

Gateway::Counters Gateway::counters(const std::string& network) const {
  const auto found = impl_->queues.find(network);
  return found == impl_->queues.end() ? Counters{} : found->second.counters;
}

}  // namespace rubicon::gateway
