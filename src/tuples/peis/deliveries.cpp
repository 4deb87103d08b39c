#include "tuples/peis/deliveries.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tuples/peis/fragments.h"

namespace rubicon::tuples::peis {

namespace {

constexpr std::size_t kGrowth = 8;  ///< timely acknowledgements that enlarge the window of a kernel by one package

}  // namespace

Deliveries::Deliveries(Scheduler& scheduler, OwnerId self, std::uint32_t seed, NodeCounters& counters, Callbacks calls)
    : scheduler_(scheduler),
      self_(self),
      last_id_(seed & kMaxId),
      counters_(counters),
      callbacks_(std::move(calls)),
      resends_(scheduler, [this] { resend_due(); }),
      acks_(scheduler, [this] { flush_all(); }) {}

void Deliveries::open(OwnerId host, bool is_ours) {
  peers_.try_emplace(host, is_ours);
}

/// Once: hello may come again, and what was received before it stays known.
void Deliveries::widen(OwnerId host) {
  const auto found = peers_.find(host);
  if (found == peers_.end() || std::exchange(found->second.is_wide, true)) return;
  found->second.window = kOfOurs;
  found->second.packages = kOfOurs.packages;
  found->second.seen.widen(kSeenOfOurs);
  fill(host, found->second);
}

void Deliveries::close(OwnerId host) {
  const auto found = peers_.find(host);
  if (found == peers_.end()) return;
  for (const auto& sent : found->second.sent) {
    bytes_ -= sent.package.size();
    end(sent.message, Outcome::kHostGone);
  }
  for (const auto& waiting : found->second.waiting) end(waiting.message, Outcome::kHostGone);
  bytes_ -= found->second.waiting_bytes;
  peers_.erase(found);
  report();
}

Result<void> Deliveries::send(OwnerId to, Port port, ByteView body, Done done) {
  const auto found = peers_.find(to);
  if (found == peers_.end())
    return fail(ErrorCode::kNotFound, fmt::format("{}: component {} is not here", to_string(port), number(to)));
  if (body.size() > kMaxLength || static_cast<std::uint16_t>(port) > kLastPort)
    return fail(ErrorCode::kOutOfRange, fmt::format("{}: {} bytes to component {}: too long, or no port of PEIS",
                                                    to_string(port), body.size(), number(to)));
  auto& peer = found->second;
  if ((peer.waiting_bytes > 0 && peer.waiting_bytes + body.size() > peer.window.waiting) ||
      bytes_ + body.size() > kMaxBytes) {
    peer.refused = true;
    return fail(ErrorCode::kBusy, fmt::format("{}: {} bytes wait for component {} already", to_string(port),
                                              peer.waiting_bytes, number(to)));
  }
  const auto fragments = count_fragments(body.size()).value();
  const auto message = done || fragments > 1 ? std::make_shared<Message>(Message{std::move(done), fragments}) : nullptr;
  if (fragments == 1 && peer.waiting.empty() && has_room(peer)) {
    enqueue(to, peer, port, body, message, 0, 0, 0);
    emit(to, peer);
    return {};
  }
  if (fragments > 1) peer.last_long = peer.last_long >= kMaxMessageId ? 1 : peer.last_long + 1;
  const auto long_number = fragments > 1 ? peer.last_long : std::uint16_t{0};
  peer.waiting.push_back({port, Bytes(body.begin(), body.end()), message, fragments, 0, long_number});
  peer.waiting_bytes += body.size();
  bytes_ += body.size();
  fill(to, peer);
  return {};
}

void Deliveries::enqueue(OwnerId to, Peer& peer, Port port, ByteView body, MessagePtr message, std::uint16_t number,
                         std::uint16_t fragments, std::uint16_t index) {
  PackageHeader header;
  header.id = next_id();
  header.ack_id = next_id();
  header.flags = static_cast<std::uint16_t>(kFlagWantsAck | (fragments > 0 ? kFlagBulk : 0));
  header.routing = Routing::kDirect;
  header.source = self_;
  header.destination = to;
  header.port = port;
  header.fragments = fragments;
  header.message = number;
  header.fragment = index;
  auto& sent = peer.sent.emplace_back();
  sent.ack_id = header.ack_id;
  sent.message = std::move(message);
  if (!spare_.empty()) {
    sent.package = std::move(spare_.back());
    spare_.pop_back();
    sent.package.clear();
  }
  append_package(sent.package, header, body);
  bytes_ += sent.package.size();
  ++peer.unacknowledged;
}

void Deliveries::fill(OwnerId to, Peer& peer) {
  while (!peer.waiting.empty() && has_room(peer)) {
    auto& next = peer.waiting.front();
    if (next.fragments == 1) {
      enqueue(to, peer, next.port, next.body, next.message, 0, 0, 0);
    } else {
      enqueue(to, peer, next.port, fragment_of(next.body, next.next), next.message, next.number, next.fragments,
              next.next);
    }
    if (++next.next < next.fragments) continue;
    peer.waiting_bytes -= next.body.size();
    bytes_ -= next.body.size();
    peer.waiting.pop_front();
  }
  emit(to, peer);
  if (peer.refused && peer.waiting_bytes <= peer.window.waiting / 2) {
    peer.refused = false;
    ready_.push_back(to);
  }
}

void Deliveries::emit(OwnerId to, Peer& peer) {
  const auto now = scheduler_.now();
  peer.to_emit = std::max(peer.to_emit, peer.first);
  for (; peer.to_emit < peer.first + peer.sent.size(); ++peer.to_emit) {
    auto& sent = peer.sent[peer.to_emit - peer.first];
    if (sent.over) continue;
    if (callbacks_.emit(to, sent.package, false) == Emitted::kFull) return;
    sent.due = now + kResendStep;
    resends_.advance_to(sent.due);
  }
}

void Deliveries::acknowledged(OwnerId from, const Acks& acks) {
  const auto found = peers_.find(from);
  if (found == peers_.end()) return;
  auto& peer = found->second;
  const auto now = scheduler_.now();
  std::size_t settled = 0;
  bool late = false;
  for (const auto id : acks.ids) {
    auto* sent = find(peer, id);
    if (!sent) continue;
    const auto message = std::move(sent->message);
    ++settled;
    late = late || is_late(*sent, now);
    settle(peer, *sent);
    if (message && --message->missing == 0) end(message, Outcome::kDelivered);
  }
  adapt(peer, settled, late);
  advance(from, peer);
  report();
}

bool Deliveries::is_late(const Sent& sent, SteadyTime now) {
  return sent.resends > 0 || now - (sent.due - kResendStep) > kLateAck;
}

/// At most one cut for all that was under way when a package was late.
void Deliveries::adapt(Peer& peer, std::size_t settled, bool late) {
  const auto most = peer.window.packages;
  if (most != kOfKernel.packages) return;
  const auto now = scheduler_.now();
  if (!late) {
    peer.settled += settled;
    peer.packages = std::min(peer.packages + peer.settled / kGrowth, most);
    peer.settled %= kGrowth;
  } else if (now >= peer.next_cut) {
    peer.packages = std::max(peer.packages * 3 / 4, kMinOfKernel);
    peer.next_cut = now + kResendStep;
  }
}

/// Null: the package is over, or was never sent. The ack ids of a host rise, and begin again behind the highest one;
/// the host acknowledges mostly in their order.
Deliveries::Sent* Deliveries::find(Peer& peer, std::uint32_t ack_id) {
  auto& sent = peer.sent;
  if (sent.empty()) return nullptr;
  auto at = sent.begin() + static_cast<std::ptrdiff_t>(
                               std::min<std::uint64_t>(std::max(peer.next_ack, peer.first) - peer.first, sent.size()));
  if (at == sent.end() || at->ack_id != ack_id) {
    const auto distance = [first = sent.front().ack_id](std::uint32_t id) {
      return id < first ? std::uint64_t{id} + kMaxId - first : id - first;
    };
    at = std::partition_point(sent.begin(), sent.end(),
                              [&](const Sent& one) { return distance(one.ack_id) < distance(ack_id); });
  }
  if (at == sent.end() || at->ack_id != ack_id || at->over) return nullptr;
  peer.next_ack = peer.first + static_cast<std::uint64_t>(at - sent.begin()) + 1;
  return &*at;
}

/// The package needs nothing more.
void Deliveries::settle(Peer& peer, Sent& sent) {
  --peer.unacknowledged;
  bytes_ -= sent.package.size();
  if (spare_.size() < kMaxSpare && sent.package.capacity() <= kMaxSpareBytes) spare_.push_back(std::move(sent.package));
  sent.package = {};
  sent.message = nullptr;
  sent.over = true;
}

void Deliveries::advance(OwnerId to, Peer& peer) {
  while (!peer.sent.empty() && peer.sent.front().over) {
    peer.sent.pop_front();
    ++peer.first;
  }
  fill(to, peer);
}

void Deliveries::end(const MessagePtr& message, Outcome outcome) {
  if (!message || std::exchange(message->ended, true)) return;
  if (message->done) ended_.push_back({message, outcome});
}

void Deliveries::report() {
  const auto ended = std::exchange(ended_, {});
  const auto ready = std::exchange(ready_, {});
  for (const auto& [message, outcome] : ended) message->done(outcome);
  for (const auto to : ready) callbacks_.ready(to);
}

void Deliveries::send_again(OwnerId to) {
  const auto found = peers_.find(to);
  if (found == peers_.end()) return;
  auto& peer = found->second;
  for (auto& sent : peer.sent) {
    if (!sent.over) restamp_package(sent.package, next_id(), 0);
  }
  peer.to_emit = peer.first;
  emit(to, peer);
}

void Deliveries::pump() {
  for (auto& [to, peer] : peers_) emit(to, peer);
}

std::size_t Deliveries::unacknowledged(OwnerId to) const {
  const auto found = peers_.find(to);
  if (found == peers_.end()) return 0;
  auto packages = found->second.unacknowledged;
  for (const auto& waiting : found->second.waiting) packages += waiting.fragments - waiting.next;
  return packages;
}

void Deliveries::resend_due() {
  const auto now = scheduler_.now();
  auto next = SteadyTime::max();
  for (auto& [to, peer] : peers_) {
    next = std::min(next, resend(to, peer, now));
    advance(to, peer);
  }
  if (next != SteadyTime::max()) resends_.advance_to(std::max(next, now + std::chrono::milliseconds(10)));
  report();
}

/// When the next package of the peer is due.
SteadyTime Deliveries::resend(OwnerId to, Peer& peer, SteadyTime now) {
  auto next = SteadyTime::max();
  const auto emitted = std::min<std::uint64_t>(peer.to_emit - std::min(peer.to_emit, peer.first), peer.sent.size());
  for (std::size_t i = 0; i < emitted; ++i) {
    auto& sent = peer.sent[i];
    if (sent.over) continue;
    if (sent.due <= now && sent.resends >= kResends) {
      const auto message = sent.message;
      ++counters_.given_up;
      settle(peer, sent);
      if (message) drop_rest(peer, message);
      end(message, Outcome::kGivenUp);
      continue;
    }
    if (sent.due <= now) {
      restamp_package(sent.package, next_id(), 0);
      const bool full = callbacks_.emit(to, sent.package, false) == Emitted::kFull;
      if (!full) ++counters_.resends, ++sent.resends;
      sent.due = now + (full ? Duration(kResendStep) : kResendStep * sent.resends);
    }
    next = std::min(next, sent.due);
  }
  return next;
}

/// The other packages of a message that was given up are not sent.
void Deliveries::drop_rest(Peer& peer, const MessagePtr& message) {
  for (auto& sent : peer.sent) {
    if (!sent.over && sent.message == message) settle(peer, sent);
  }
  std::erase_if(peer.waiting, [&](const Waiting& waiting) {
    if (waiting.message != message) return false;
    peer.waiting_bytes -= waiting.body.size();
    bytes_ -= waiting.body.size();
    return true;
  });
}

void Deliveries::acknowledge(OwnerId source, std::uint32_t ack_id) {
  const auto found = peers_.find(source);
  if (found == peers_.end()) return;
  auto& acks = found->second.acks;
  acks.push_back(ack_id);
  if (acks.size() >= kMaxAcks) return flush(source, found->second);
  if (acks.size() == 1) acks_.advance_to(scheduler_.now() + kAckDelay);
}

bool Deliveries::is_new(OwnerId source, std::uint32_t ack_id) {
  const auto found = peers_.find(source);
  return found != peers_.end() && found->second.seen.add(ack_id);
}

PackageHeader Deliveries::next_header(Routing routing, Port port, OwnerId destination) {
  PackageHeader header;
  header.id = header.ack_id = next_id();
  header.routing = routing;
  header.source = self_;
  header.destination = destination;
  header.port = port;
  return header;
}

void Deliveries::flush(OwnerId source, Peer& peer) {
  Acks acks{std::exchange(peer.acks, {})};
  Bytes package;
  append_package(package, next_header(Routing::kDirect, Port::kAcks, source), write(acks));
  callbacks_.emit(source, package, true);  // lost acks come again with the resends
}

void Deliveries::flush_all() {
  for (auto& [source, peer] : peers_) {
    if (!peer.acks.empty()) flush(source, peer);
  }
}

}  // namespace rubicon::tuples::peis
