#include "gateway/gateway.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <map>
#include <utility>
#include <vector>

#include "base/assert.h"
#include "base/lifetime.h"
#include "base/limited_log.h"
#include "gateway/gateway_tuple.h"
#include "gateway/inbox.h"
#include "gateway/listeners.h"
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

/// Requests and application messages nobody hears must be answered; reports may go unheard.
bool requires_listener(MessageKind kind) {
  return kind == MessageKind::kOpaque || kind == MessageKind::kActuate || kind == MessageKind::kSample ||
         kind == MessageKind::kSetProperty || kind == MessageKind::kProbe;
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
}

}  // namespace

struct Gateway::Impl {
  Impl(Scheduler& s, TupleSpace& space, base::LogSink& sink, GatewayLimits l)
      : scheduler(s),
        self(space.self()),
        log(Log(sink, "gateway"), s),
        limits(l),
        last_number(static_cast<std::uint64_t>(s.wall_now().time_since_epoch().count()) << 10),
        next_turn(s, [this] { turn(); }),
        door(
            space, limits, [this](Message message, std::size_t size) { return arrived(std::move(message), size); },
            [this](const Envelope& envelope, Outcome outcome, std::string why) {
              undelivered(envelope, outcome, std::move(why));
            },
            [this](OwnerId from, const std::string& why) {
              log.warning("forged", fmt::format("a message of {} was refused: {}", number(from), why));
            }) {}

  Inbox& inbox(const std::string& network);
  Result<void> arrived(Message message, std::size_t size);
  std::uint64_t send(Message message);
  void stamp(Message& message);
  void turn();
  /// Counts and answers.
  void undelivered(const Envelope& envelope, Outcome outcome, std::string why);
  void answer(const Envelope& envelope, Outcome outcome, std::string why);
  void report_drops(Inbox& box);
  void no_room(Inbox& box, const Message& message);

  void route(Message& message, Counters& count);
  void to_listeners(const Message& message, Counters& count);
  void to_network(const Message& message, Counters& count);
  Result<void> to_own_network(const Message& message);
  bool is_ours(const Message& message) const;
  bool names_only_a_device(const Message& message) const;
  void to_device(Message& message, Counters& count);

  Scheduler& scheduler;
  IslandId self;
  base::LimitedLog log;
  GatewayLimits limits;
  network::Supervisor* networks = nullptr;
  NetworksOf networks_of;
  CommandCall take_command;
  std::uint64_t last_number;  ///< from the wall clock on, so that no number comes twice, restarts included
  std::map<std::string, Inbox> inboxes;
  Inbox* last_inbox = nullptr;
  std::vector<Message> foreign, outbox;  ///< from other islands; from own components
  std::size_t foreign_bytes = 0;
  std::array<Listeners, std::variant_size_v<model::Body>> listeners;
  std::map<std::string, Listeners, std::less<>> user_listeners;
  Counters own;
  base::OncePerTurn next_turn;
  GatewayTuple door;
};

Inbox& Gateway::Impl::inbox(const std::string& network) {
  if (last_inbox == nullptr || last_inbox->network() != network)
    last_inbox = &inboxes.try_emplace(network, network, limits).first->second;
  return *last_inbox;
}

void Gateway::Impl::stamp(Message& message) {
  if (message.origin != model::kNoOwner) return;
  message.origin = self;
  message.number = ++last_number;
}

/// One turn of the loop: everything that waits, and nothing that comes meanwhile.
void Gateway::Impl::turn() {
  auto from_abroad = std::exchange(foreign, {});
  auto from_here = std::exchange(outbox, {});
  foreign_bytes = 0;
  for (auto& [network, box] : inboxes) {
    box.drain([&, count = &box.counters](Message& message) { route(message, *count); });
    report_drops(box);
  }
  for (Message& message : from_abroad) route(message, own);
  for (Message& message : from_here) route(message, own);
}

Result<void> Gateway::Impl::arrived(Message message, std::size_t size) {
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
  if (outcome == Outcome::kUndeliverable) ++own.undeliverable;
  answer(envelope, outcome, std::move(why));
}

/// Answers have as much room again as what they answer.
void Gateway::Impl::answer(const Envelope& envelope, Outcome outcome, std::string why) {
  if (!envelope.answerable || outbox.size() >= limits.queue * 2) return;
  Message answer;
  answer.source = envelope.destination;
  answer.source.island = self;  // an answer to a message for another island is said here
  answer.destination = envelope.source;
  answer.body = model::Acknowledge{envelope.number, outcome, std::move(why)};
  stamp(answer);
  outbox.push_back(std::move(answer));
  next_turn.request();
}

void Gateway::Impl::report_drops(Inbox& box) {
  const auto dropped = box.counters.dropped_readings;
  if (dropped == box.reported_drops) return;
  const auto text = fmt::format("network {}: {} readings dropped so far because more than {} were waiting",
                                box.network(), dropped, limits.queue);
  if (log.warning(box.network() + " drops", text)) box.reported_drops = dropped;
}

void Gateway::Impl::no_room(Inbox& box, const Message& message) {
  ++box.counters.refused_busy;
  auto why = fmt::format("too many messages of network {} are waiting", box.network());
  log.warning(box.network(), why);
  if (message.kind() == MessageKind::kOpaque) answer(Envelope(message), Outcome::kBusy, std::move(why));
}

void Gateway::Impl::route(Message& message, Counters& count) {
  if (message.destination.island != self) return door.send(message);
  if (names_only_a_device(message)) return to_device(message, count);
  // An answer for a device is for those who know it: networks take none.
  if (message.destination.network.empty() || message.kind() == MessageKind::kAcknowledge)
    return to_listeners(message, count);
  to_network(message, count);
}

bool Gateway::Impl::names_only_a_device(const Message& message) const {
  const auto& to = message.destination;
  return networks_of && to.network.empty() && !to.device.empty() && requires_listener(message.kind());
}

/// A mote's message to a mote of another island names no network (wsn.md, section 9.8).
void Gateway::Impl::to_device(Message& message, Counters& count) {
  auto& to = message.destination;
  auto found = networks_of(to.device);
  if (found.empty()) return to_listeners(message, count);
  if (found.size() == 1) {
    to.network = std::move(found.front());
    return to_network(message, count);
  }
  undelivered(Envelope(message), Outcome::kRefused,
              fmt::format("device {} is in {} networks of island {} ({}): name one", model::quoted(to.device),
                          found.size(), number(self), fmt::join(found, ", ")));
}

void Gateway::Impl::to_listeners(const Message& message, Counters& count) {
  std::size_t heard = listeners[message.body.index()].tell(message);
  const auto* opaque = std::get_if<model::Opaque>(&message.body);
  if (opaque) {
    const auto user = user_listeners.find(opaque->type);
    if (user != user_listeners.end()) heard += user->second.tell(message);
  }
  if (heard > 0 || !requires_listener(message.kind())) {
    ++count.delivered;
    return;
  }
  const auto what = opaque ? model::quoted(opaque->type) : std::string(to_string(message.kind()));
  const auto& device = message.destination.device;
  undelivered(Envelope(message), Outcome::kUndeliverable,
              device.empty()
                  ? fmt::format("nobody on island {} listens to {} messages", number(self), what)
                  : fmt::format("no network of island {} has a device {}", number(self), model::quoted(device)));
}

void Gateway::Impl::to_network(const Message& message, Counters& count) {
  if (auto sent = to_own_network(message); !sent)
    return undelivered(Envelope(message), outcome_of(sent.error().code), std::move(sent.error().text));
  ++count.delivered;
}

/// The island's own parts may send anything; others only what docs/decisions/015 allows.
Result<void> Gateway::Impl::to_own_network(const Message& message) {
  if (networks == nullptr) return fail(ErrorCode::kNotFound, "this island has no networks");
  const auto kind = message.kind();
  if (is_ours(message) || kind == MessageKind::kOpaque) return networks->send(message);
  const bool command = kind == MessageKind::kActuate || kind == MessageKind::kSetProperty;
  if (command && take_command) return take_command(message);
  return fail(ErrorCode::kRefused,
              fmt::format("networks take no {} of others: subscribe to tuples and set them", to_string(kind)));
}

bool Gateway::Impl::is_ours(const Message& message) const {
  return message.origin == self && message.source.island == self && message.source.network.empty();
}

Gateway::Gateway(Scheduler& scheduler, TupleSpace& space, base::LogSink& log, GatewayLimits limits)
    : impl_(std::make_unique<Impl>(scheduler, space, log, limits)) {}

Gateway::~Gateway() = default;

void Gateway::limit(GatewayLimits limits) {
  impl_->limits = limits;
  for (auto& [network, box] : impl_->inboxes) box.limit(limits);
}

void Gateway::forget(const std::string& network) {
  const auto box = impl_->inboxes.find(network);
  if (box == impl_->inboxes.end()) return;
  add(impl_->own, box->second.counters);  // the island's sums never shrink
  impl_->last_inbox = nullptr;
  impl_->inboxes.erase(box);
}

void Gateway::find_devices(NetworksOf networks_of) {
  impl_->networks_of = std::move(networks_of);
}

void Gateway::take_commands(CommandCall call) {
  impl_->take_command = std::move(call);
}

void Gateway::connect(network::Supervisor& networks) {
  impl_->networks = &networks;
}

Handle Gateway::subscribe(MessageKind kind, MessageCall call) {
  return impl_->listeners[static_cast<std::size_t>(kind)].add(std::move(call));
}

Handle Gateway::subscribe_user(std::string_view type, MessageCall call) {
  return impl_->user_listeners[std::string(type)].add(std::move(call));
}

std::uint64_t Gateway::send(Message message) {
  RUBICON_DEBUG_ASSERT(impl_->scheduler.on_loop_thread());
  return impl_->send(std::move(message));
}

void Gateway::on_taken(std::function<void(std::uint64_t number)> call) {
  impl_->door.on_taken(std::move(call));
}

void Gateway::from_network(const std::string& network, Message message) {
  RUBICON_DEBUG_ASSERT(impl_->scheduler.on_loop_thread());
  impl_->stamp(message);
  Inbox& box = impl_->inbox(network);
  if (!box.add(message)) impl_->no_room(box, message);
  impl_->next_turn.request();
}

Gateway::Counters Gateway::counters() const {
  Counters sum = impl_->own;
  add(sum, impl_->door.counters);
  for (const auto& [network, box] : impl_->inboxes) add(sum, box.counters);
  return sum;
}

Gateway::Counters Gateway::counters(const std::string& network) const {
  const auto found = impl_->inboxes.find(network);
  return found == impl_->inboxes.end() ? Counters{} : found->second.counters;
}

}  // namespace rubicon::gateway
