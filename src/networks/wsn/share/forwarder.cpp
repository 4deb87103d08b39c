#include "networks/wsn/share/forwarder.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <utility>
#include <vector>

#include "base/log.h"
#include "motes/framing.h"
#include "motes/mote_packet.h"
#include "motes/mote_records.h"

namespace rubicon::networks::wsn::share {

namespace {

using transport::Endpoint;

/// Longest AM payload that a sink accepts (wsn.md 4.3).
constexpr std::size_t kMaxPayload = 114;
/// Offset of the AM type, after dispatch byte, addresses, length and group (wsn.md 3).
constexpr std::size_t kTypeAt = 7;
/// Packets that arrive this soon after one expired had waited in the system's buffers for as long.
constexpr Duration kBacklogTime = std::chrono::milliseconds(100);

bool is_config(ByteView packet) {
  return packet[0] == 0 && packet[kTypeAt] == static_cast<std::uint8_t>(motes::AmType::kConfig);
}

/// SET_ISLAND_ID of this island: a command and 2 bytes (wsn.md 7.1). Further bytes do not matter.
bool sets_island(ByteView packet, std::uint16_t island) {
  const auto config = motes::encode_config({motes::kSetIslandId, island});
  const auto payload = packet.subspan(motes::kAmOverhead);
  return payload.size() >= config.size() && std::equal(config.begin(), config.end(), payload.begin());
}

struct Client : std::enable_shared_from_this<Client> {
  bool waits() const { return !packet.empty(); }
  ByteView unread() const { return ByteView(rest).subspan(read); }

  std::string name;
  std::unique_ptr<transport::TcpStream> stream;  ///< null: it disconnected while its packets wait
  motes::ForwarderReader reader;
  Timer greeting, expiry;
  SteadyTime expires{};        ///< of the packet and of the rest, which were read together
  SteadyTime backlog_until{};  ///< packets that arrive before this are too old
  Bytes packet;                ///< waits until it is accepted
  Bytes rest;                  ///< bytes after that packet, unread from `read` on
  std::size_t read = 0;
  unsigned bad_in_a_row = 0;
  bool dropped = false;
};

using ClientPtr = std::shared_ptr<Client>;

enum class SendOutcome : std::uint8_t { kSent, kTooSlow, kLost };

}  // namespace

struct Forwarder::Impl {
  Impl(ForwarderOptions o, Scheduler& s, transport::Transports& t, ForwarderCallbacks c)
      : options(std::move(o)), scheduler(s), transports(t), callbacks(std::move(c)) {}

  void accept(std::unique_ptr<transport::TcpStream> stream, transport::TcpCallbacks& stream_calls);
  void received(Client& client, ByteView bytes);
  ByteView take(Client& client, ByteView bytes);
  bool is_wanted(Client& client, ByteView packet);
  bool is_bad(Client& client, ByteView packet);
  bool pass(Client& client, ByteView packet);
  void keep(Client& client, ByteView packet);
  SteadyTime due(const Client& client) const;
  void await_expiry(Client& client);
  void accepted();
  void expire(const ClientPtr& client);
  void drop_expired(const Client& client);
  void resume_client(const ClientPtr& client);
  SendOutcome send(Client& client, ByteView framed);
  std::size_t connected() const;
  void lost(Client& client);
  void disconnect(Client& client, const std::string& counter, std::string_view why);
  void drop(Client& client);
  /// `text` returns the text; called only if the line is logged.
  template <class Text>
  void note(const std::string& counter, Text text);

  ForwarderOptions options;
  Scheduler& scheduler;
  transport::Transports& transports;
  ForwarderCallbacks callbacks;
  std::unique_ptr<transport::TcpListener> listener;
  std::vector<ClientPtr> clients;
  std::deque<ClientPtr> waiting;  ///< clients whose packets wait, the next one to offer first
  std::map<std::string, std::uint64_t> counters{
      {"clients-total", 0},   {"packets-to-clients", 0},   {"packets-from-clients", 0}, {"dropped-bad-packets", 0},
      {"dropped-config", 0},  {"dropped-slow-clients", 0}, {"dropped-strangers", 0},    {"dropped-silent", 0},
      {"refused-clients", 0}, {"dropped-expired", 0},      {"dropped-gone", 0}};
  base::RateLimit limit;
  SteadyTime accepted_at{};  ///< when a packet of any client was last accepted
};

template <class Text>
void Forwarder::Impl::note(const std::string& counter, Text text) {
  ++counters[counter];
  if (callbacks.note && limit.allow(counter, scheduler.now())) callbacks.note(counter, text());
}

std::size_t Forwarder::Impl::connected() const {
  const auto is_there = [](const ClientPtr& client) { return client->stream != nullptr; };
  return static_cast<std::size_t>(std::count_if(clients.begin(), clients.end(), is_there));
}

void Forwarder::Impl::accept(std::unique_ptr<transport::TcpStream> stream, transport::TcpCallbacks& stream_calls) {
  const auto name = to_string(stream->remote());
  if (const auto now = connected(); now >= options.clients)
    return note("refused-clients",
                [&] { return fmt::format("client {}: refused, {} are connected (share-clients)", name, now); });
  const auto client = std::make_shared<Client>();
  client->name = name;
  client->stream = std::move(stream);
  // If this fails, the stream ends and reports it.
  (void)client->stream->send(motes::kForwarderHello);
  client->greeting = scheduler.after(options.greeting_timeout, [this, client = client.get()] {
    const auto span = std::chrono::duration<double>(options.greeting_timeout).count();
    disconnect(*client, "dropped-silent", fmt::format("it did not greet within {} s", span));
  });
  clients.push_back(client);
  ++counters["clients-total"];
  stream_calls.received = [this, client = client.get()](ByteView bytes) { received(*client, bytes); };
  stream_calls.failed = [this, client = client.get()](const Error&) { lost(*client); };
}

void Forwarder::Impl::received(Client& client, ByteView bytes) {
  const auto keep = client.shared_from_this();
  if (!client.waits()) client.expires = scheduler.now() + options.packet_lifetime;
  const auto left = client.waits() ? bytes : take(client, bytes);
  client.rest.insert(client.rest.end(), left.begin(), left.end());
}

/// Reads packets until one has to wait; returns the bytes after that.
ByteView Forwarder::Impl::take(Client& client, ByteView bytes) {
  while (!client.dropped) {
    const auto packet = client.reader.next(bytes);
    if (client.reader.greeted()) client.greeting.cancel();
    if (!packet) {
      disconnect(client, "dropped-strangers", packet.error().text);
    } else if (!*packet) {
      break;
    } else if (is_wanted(client, **packet) && !pass(client, **packet)) {
      return bytes;
    }
  }
  return {};
}

bool Forwarder::Impl::is_wanted(Client& client, ByteView packet) {
  if (is_bad(client, packet)) return false;
  if (!is_config(packet) || options.may_configure || (options.island && sets_island(packet, *options.island)))
    return true;
  note("dropped-config", [&] {
    return fmt::format(
        "client {}: dropped a Config packet, which would change the island of the sink (share-config: yes allows it)",
        client.name);
  });
  return false;
}

bool Forwarder::Impl::is_bad(Client& client, ByteView packet) {
  constexpr auto kMaxSize = motes::kAmOverhead + kMaxPayload;
  if (packet.size() >= motes::kAmOverhead && packet.size() <= kMaxSize) {
    client.bad_in_a_row = 0;
    return false;
  }
  note("dropped-bad-packets", [&] {
    return fmt::format("client {}: dropped a packet of {} bytes, expected {} to {}", client.name, packet.size(),
                       motes::kAmOverhead, kMaxSize);
  });
  if (++client.bad_in_a_row >= options.max_bad_packets)
    disconnect(client, "dropped-strangers", fmt::format("{} bad packets in a row", client.bad_in_a_row));
  return true;
}

/// False: the packet has to wait.
bool Forwarder::Impl::pass(Client& client, ByteView packet) {
  if (scheduler.now() < client.backlog_until) {
    drop_expired(client);
    return true;
  }
  if (!waiting.empty() || !callbacks.packet(packet)) {
    keep(client, packet);
    return false;
  }
  accepted();
  return true;
}

void Forwarder::Impl::accepted() {
  ++counters["packets-from-clients"];
  accepted_at = scheduler.now();
}

void Forwarder::Impl::keep(Client& client, ByteView packet) {
  client.packet.assign(packet.begin(), packet.end());
  waiting.push_back(client.shared_from_this());
  await_expiry(client);
  if (client.stream) client.stream->hold(true);
}

/// A busy sink accepts one packet after the other, however long the queue; only a sink that is away accepts none.
SteadyTime Forwarder::Impl::due(const Client& client) const {
  return std::max(client.expires, accepted_at + options.packet_lifetime);
}

void Forwarder::Impl::await_expiry(Client& client) {
  client.expiry = scheduler.at(due(client), [this, client = &client] {
    const auto keep = client->shared_from_this();
    if (due(*client) > scheduler.now()) return await_expiry(*client);
    expire(keep);
  });
}

/// Its packet waited for too long, and so did the bytes that came with it.
void Forwarder::Impl::expire(const ClientPtr& client) {
  std::erase(waiting, client);
  drop_expired(*client);
  client->backlog_until = scheduler.now() + kBacklogTime;
  resume_client(client);
}

void Forwarder::Impl::drop_expired(const Client& client) {
  note("dropped-expired", [&] {
    const auto span = std::chrono::duration<double>(options.packet_lifetime).count();
    return fmt::format("client {}: dropped a packet that the sink could not take within {} s", client.name, span);
  });
}

/// Its packet was accepted or dropped: continues with the rest.
void Forwarder::Impl::resume_client(const ClientPtr& client) {
  client->packet.clear();
  const auto left = take(*client, client->unread());
  if (client->dropped) return;
  client->read = client->rest.size() - left.size();
  if (client->waits()) return;
  client->expiry.cancel();
  client->rest.clear();
  client->read = 0;
  if (client->stream) return client->stream->hold(false);
  drop(*client);
}

/// A client that is held is not read from: that it disconnected may become known only here.
SendOutcome Forwarder::Impl::send(Client& client, ByteView framed) {
  if (!client.stream || !client.reader.greeted()) return SendOutcome::kSent;
  if (client.stream->queued() + framed.size() > options.client_bytes) return SendOutcome::kTooSlow;
  const auto sent = client.stream->send(framed);
  if (!sent) return sent.error().code == ErrorCode::kBusy ? SendOutcome::kTooSlow : SendOutcome::kLost;
  ++counters["packets-to-clients"];
  return SendOutcome::kSent;
}

void Forwarder::Impl::lost(Client& client) {
  const auto keep = client.shared_from_this();
  client.stream.reset();
  if (!client.waits()) return drop(client);
  if (clients.size() - connected() <= options.clients) return;
  note("dropped-gone", [&] {
    return fmt::format("client {}: its packets are dropped: it disconnected, and the packets of {} such clients wait",
                       client.name, options.clients);
  });
  drop(client);
}

void Forwarder::Impl::disconnect(Client& client, const std::string& counter, std::string_view why) {
  const auto keep = client.shared_from_this();
  lost(client);
  note(counter, [&] { return fmt::format("client {}: disconnected: {}", client.name, why); });
}

void Forwarder::Impl::drop(Client& client) {
  client.dropped = true;
  client.stream.reset();
  client.greeting.cancel();
  client.expiry.cancel();
  const auto is_it = [&](const ClientPtr& other) { return other.get() == &client; };
  const auto keep = client.shared_from_this();
  std::erase_if(waiting, is_it);
  std::erase_if(clients, is_it);
}

Forwarder::Forwarder(ForwarderOptions options, Scheduler& scheduler, transport::Transports& transports,
                     ForwarderCallbacks callbacks)
    : impl_(std::make_unique<Impl>(std::move(options), scheduler, transports, std::move(callbacks))) {}

Forwarder::~Forwarder() = default;

Result<void> Forwarder::open() {
  if (impl_->listener) return {};
  auto listener = impl_->transports.listen_tcp(
      impl_->options.listen,
      [impl = impl_.get()](std::unique_ptr<transport::TcpStream> stream) {
        transport::TcpCallbacks stream_calls;
        impl->accept(std::move(stream), stream_calls);
        return stream_calls;
      },
      [impl = impl_.get()](Error why) {
        impl->listener.reset();
        if (impl->callbacks.failed) impl->callbacks.failed(std::move(why));
      });
  if (!listener) return fail(listener.error());
  impl_->listener = std::move(*listener);
  return {};
}

void Forwarder::broadcast(ByteView packet) {
  if (packet.empty() || packet.size() > motes::kMaxPacket) return;
  const auto framed = motes::forwarder_packet(packet);
  std::vector<ClientPtr> slow, lost;
  for (const auto& client : impl_->clients) {
    const auto outcome = impl_->send(*client, framed);
    if (outcome == SendOutcome::kTooSlow) slow.push_back(client);
    if (outcome == SendOutcome::kLost) lost.push_back(client);
  }
  for (const auto& client : slow) impl_->disconnect(*client, "dropped-slow-clients", "it reads too slowly");
  for (const auto& client : lost) impl_->lost(*client);
}

void Forwarder::resume() {
  auto& waiting = impl_->waiting;
  while (!waiting.empty()) {
    const auto client = waiting.front();
    if (impl_->due(*client) <= impl_->scheduler.now()) {
      impl_->expire(client);
      continue;
    }
    if (!impl_->callbacks.packet(client->packet)) return;
    impl_->accepted();
    waiting.pop_front();
    impl_->resume_client(client);
  }
}

Endpoint Forwarder::local() const {
  return impl_->listener ? impl_->listener->local() : Endpoint{};
}

std::size_t Forwarder::clients() const {
  return impl_->connected();
}

std::map<std::string, std::uint64_t> Forwarder::counters() const {
  auto counters = impl_->counters;
  counters["clients"] = clients();
  return counters;
}

}  // namespace rubicon::networks::wsn::share
