#include "tuples/peis/kernel_peer.h"

#include <algorithm>
#include <utility>

#include "base/assert.h"

namespace rubicon::tuples::peis {

namespace {

/// The simulated network takes all that a test sends.
void accepted(const Result<void>& sent) {
  RUBICON_ASSERT(sent || sent.error().code == ErrorCode::kUnreachable);
}

}  // namespace

KernelPeer::KernelPeer(Scheduler& scheduler, transport::Transports& transports, std::uint32_t id, std::uint16_t port)
    : magic(0x100000 + id), scheduler_(scheduler), transports_(transports), id_(OwnerId{id}), port_(port), random_(id) {
  next_routing_ = scheduler.now() + 10s;
  next_connect_ = scheduler.now() + 2s;
  tick();
}
KernelPeer::~KernelPeer() = default;

HostRecord KernelPeer::record() const {
  HostRecord record{id_, magic, host_name, "kernel@" + host_name + "!1", {}, cluster(), 0};
  record.addresses.push_back({"lo", true, AddressType::kTcp4, {127, 0, 0, 1}, port_});
  return record;
}

OwnerId KernelPeer::cluster() const {
  return routes_.empty() ? id_ : std::min(id_, routes_.begin()->first);
}

void KernelPeer::listen() {
  listener_ = std::move(*transports_.listen_tcp({"127.0.0.1", port_}, [this](auto stream) {
    const auto id = ++last_link_;
    links_[id].stream = std::move(stream);
    links_[id].accepted = true;
    return calls(id);
  }));
}

void KernelPeer::announce() {
  transport::UdpOptions options;
  options.local = {std::string(kMulticastGroup), kMulticastPort};
  options.reuse_address = true;
  options.multicast = {{std::string(kMulticastGroup)}, "127.0.0.1", 3, true};
  transport::UdpCallbacks calls;
  calls.received = [this](const auto&, ByteView bytes) {
    const auto heard = read_announcement(bytes);
    if (!heard || heard->network != network || heard->host.id == id_) return;
    known_[heard->host.id] = heard->host;
    if (heard->host.host_name == host_name && heard->host.id < id_) next_announcement_ = scheduler_.now() + 3s;
  };
  socket_ = std::move(*transports_.open_udp(options, std::move(calls)));
  announces_ = true;
  next_announcement_ = scheduler_.now() + 3s;
}

void KernelPeer::connect(std::uint16_t port, std::uint32_t flags) {
  const auto id = ++last_link_;
  auto events = calls(id);
  events.connected = [this, id, flags] {
    auto greeting = peis::write(ConnectMessage{id_, flags, network});
    greeting[3] = static_cast<std::uint8_t>(version & 0xff);
    greeting[2] = static_cast<std::uint8_t>(version >> 8);
    accepted(links_.at(id).stream->send(greeting));
    begin(id);
  };
  auto& link = links_[id];
  link.stream = std::move(*transports_.open_tcp({{"127.0.0.1", port}}, std::move(events)));
}

transport::TcpCallbacks KernelPeer::calls(std::uint64_t id) {
  transport::TcpCallbacks calls;
  calls.received = [this, id](ByteView bytes) { arrived(id, bytes); };
  calls.failed = [this, id](const Error&) {
    const auto found = links_.find(id);
    if (found == links_.end() || !notices_fin) return;
    std::erase_if(routes_, [&](const auto& item) { return item.second.link == id; });
    links_.erase(found);
  };
  return calls;
}

/// Host record and routing as link packages, the record as broadcast: as in peis-g6.pcap at 5.994 s.
void KernelPeer::begin(std::uint64_t id) {
  auto& link = links_.at(id);
  link.greeted = true;
  const auto own = peis::write(HostRecordMessage{record(), false});
  write(link, header(Routing::kLink, Port::kHostInfo), own);
  if (sends_routing) write(link, header(Routing::kLink, Port::kRouting), peis::write(routing_page()));
  write(link, header(Routing::kBroadcast, Port::kHostInfo), own);
}

void KernelPeer::arrived(std::uint64_t id, ByteView bytes) {
  auto& link = links_.at(id);
  link.packages.append(bytes);
  if (link.accepted && !link.greeted) {
    const auto greeting = link.packages.connect();
    if (!greeting || !*greeting) return;
    greetings.push_back(**greeting);
    if ((*greeting)->id == id_ || (*greeting)->network != network) return void(links_.erase(id));
    link.peer = (*greeting)->id;
    begin(id);
  }
  if (each_step == 0) take_packages(id, SIZE_MAX);
}

void KernelPeer::take_packages(std::uint64_t id, std::size_t most) {
  for (std::size_t i = 0; i < most && links_.contains(id); ++i) {
    const auto package = links_.at(id).packages.next();
    if (!package || !*package) return;
    const bool is_lost = (*package)->header.port == Port::kDeadHost && lost_deaths > 0 && lost_deaths-- > 0;
    if (!is_lost && !loses()) take(id, **package);
  }
}

void KernelPeer::take(std::uint64_t id, const Package& package) {
  const auto& h = package.header;
  received.push_back({scheduler_.now(), h, std::string(base::as_text(package.body))});
  if (h.routing == Routing::kLink) links_.at(id).peer = h.source;
  if (h.routing == Routing::kDirect && h.destination != id_) {
    if (h.port == Port::kQueryHost) answer_for(h.destination, *read_query_host(package.body));
    return;
  }
  if (h.wants_ack() && acknowledges) {
    acks_[h.source].push_back(h.ack_id);
    const auto wait = acks_[h.source].size() >= kMaxAcks ? Duration(0) : Duration(200ms);
    next_ack_ = std::min(next_ack_ == SteadyTime{} ? SteadyTime::max() : next_ack_, scheduler_.now() + wait);
  }
  if (!seen_.insert(h.ack_id).second) return;
  switch (h.port) {
    case Port::kRouting: return take_routing(id, *read_routing_page(package.body));
    case Port::kHostInfo: {
      const auto host = read_host_info(package.body)->host;
      const auto before = std::exchange(known_[host.id], host);
      if (resets_always && h.routing == Routing::kLink) return void(links_.erase(id));
      if (resets_reborn && before.magic != 0 && before.magic != host.magic) links_.erase(id);
      return;
    }
    case Port::kAcks:
      std::erase_if(unacknowledged_, [acks = *read_acks(package.body)](const auto& sent) {
        return std::find(acks.ids.begin(), acks.ids.end(), sent.header.ack_id) != acks.ids.end();
      });
      return;
    case Port::kQueryHost: {
      const auto query = *read_query_host(package.body);
      if (query.magic != kAnyId) return;  // never answered: section 6.4, 30
      const auto answer = peis::write(HostRecordMessage{record(), false});
      return send(number(query.asker), Port::kHostInfo, std::string(base::as_text(answer)));
    }
    case Port::kDeadHost: {
      const auto dead = *read_dead_host(package.body);
      if (dead.reason != DeathReason::kLost || dead.id == id_) return;
      routes_.erase(dead.id);
      std::erase_if(links_, [&](const auto& item) { return item.second.peer == dead.id; });
      return;
    }
    default:
      messages.push_back(received.back());
      if (on_message) on_message(Received(messages.back()));
  }
}

/// A kernel on the way answers from what it knows (section 6.4, 30). It passes on nothing else here.
void KernelPeer::answer_for(OwnerId host, const QueryHost& query) {
  const auto known = known_.find(host);
  if (known == known_.end() || query.magic != kAnyId) return;
  const auto answer = peis::write(HostRecordMessage{known->second, true});
  send(number(query.asker), Port::kHostInfo, std::string(base::as_text(answer)));
}

/// Best = largest sequence - metric; no split horizon.
void KernelPeer::take_routing(std::uint64_t id, const RoutingPage& page) {
  for (const auto& entry : page.entries) {
    const int hops = entry.hops + 1;
    if (entry.id == id_) continue;
    const auto known = routes_.find(entry.id);
    if (hops >= kUnreachableMetric) {
      if (known != routes_.end() && known->second.link == id) routes_.erase(known);
      continue;
    }
    const auto score = [](std::uint32_t sequence, int metric) { return static_cast<std::int64_t>(sequence) - metric; };
    if (known == routes_.end() || known->second.link == id ||
        score(entry.sequence, hops) > score(known->second.sequence, known->second.hops))
      routes_[entry.id] = {id, hops, entry.sequence, entry.magic};
  }
}

PackageHeader KernelPeer::header(Routing routing, Port port, std::uint32_t to) {
  PackageHeader header;
  header.id = header.ack_id = random_id();
  header.routing = routing;
  header.source = id_;
  header.destination = OwnerId{to};
  header.port = port;
  return header;
}

void KernelPeer::write(Link& link, PackageHeader header, ByteView body) {
  if (loses()) return;
  header.counter = link.counter++;
  Bytes package;
  append_package(package, header, body);
  if (!link.stream->send(package)) ++link.failures;
}

void KernelPeer::send_raw(PackageHeader header, ByteView body) {
  for (auto& [id, link] : links_) write(link, header, body);
}

void KernelPeer::send_bytes(ByteView bytes) {
  for (auto& [id, link] : links_) accepted(link.stream->send(bytes));
}

void KernelPeer::route(const PackageHeader& header, ByteView body) {
  for (auto& [id, link] : links_) {
    if (link.peer == header.destination && link.failures < 2) return write(link, header, body);
  }
  const auto known = routes_.find(header.destination);
  if (known != routes_.end() && links_.contains(known->second.link)) write(links_.at(known->second.link), header, body);
}

void KernelPeer::send(std::uint32_t to, Port port, const std::string& body) {
  auto package = header(Routing::kDirect, port, to);
  package.ack_id = random_id();
  package.flags = kFlagWantsAck;
  const auto bytes = base::as_bytes(body);
  unacknowledged_.push_back({package, Bytes(bytes.begin(), bytes.end()), 0, scheduler_.now() + kResendStep});
  route(package, bytes);
}

RoutingPage KernelPeer::routing_page() const {
  RoutingPage page;
  page.sequence = sequence_;
  page.entries.push_back({id_, sequence_, magic, 0, static_cast<std::uint8_t>(links_.size())});
  for (const auto& [id, known] : routes_)
    page.entries.push_back({id, known.sequence, known.magic, static_cast<std::uint8_t>(known.hops), 1});
  return page;
}

void KernelPeer::send_routing() {
  if (!sends_routing) return;
  ++sequence_;
  const auto page = routing_page();
  for (auto& [id, link] : links_) {
    if (link.greeted) write(link, header(Routing::kLink, Port::kRouting), peis::write(page));
  }
}

void KernelPeer::tick() {
  timer_ = scheduler_.after(10ms, [this] { tick(); });
  const auto now = scheduler_.now();
  std::erase_if(links_, [](const auto& item) { return item.second.failures >= 2; });
  std::vector<std::uint64_t> all;
  for (const auto& [id, link] : links_) all.push_back(id);
  for (const auto id : all) take_packages(id, each_step);
  if (now >= next_routing_) next_routing_ = now + 10s, send_routing();
  if (next_ack_ != SteadyTime{} && now >= next_ack_) {
    next_ack_ = {};
    for (auto& [to, ids] : std::exchange(acks_, {})) {
      for (std::size_t i = 0; i < ids.size(); i += kMaxAcks) {
        const Acks acks{{ids.begin() + static_cast<std::ptrdiff_t>(i),
                         ids.begin() + static_cast<std::ptrdiff_t>(std::min(ids.size(), i + kMaxAcks))}};
        route(header(Routing::kDirect, Port::kAcks, number(to)), peis::write(acks));
      }
    }
  }
  for (auto& sent : unacknowledged_) {
    if (sent.due > now) continue;
    if (++sent.resends > kResends) given_up.insert(number(sent.header.destination));
    sent.header.id = random_id();
    sent.due = now + kResendStep * sent.resends;
    if (sent.resends <= kResends) route(sent.header, sent.body);
  }
  std::erase_if(unacknowledged_, [](const auto& sent) { return sent.resends > kResends; });
  if (announces_ && now >= next_announcement_) {
    next_announcement_ = now + 1s;
    const auto datagram = peis::write(Announcement{network, record()});
    accepted(socket_->send({std::string(kMulticastGroup), kMulticastPort}, datagram));
  }
  if (!connects || !announces_ || now < next_connect_) return;
  next_connect_ = now + 2s;
  for (const auto& [id, host] : known_) {
    if (host.cluster == cluster() || routes_.contains(id) || host.addresses.empty()) continue;
    return connect(static_cast<std::uint16_t>(host.addresses[0].port));
  }
}

void KernelPeer::hold(bool held) {
  for (auto& [id, link] : links_) link.stream->hold(held);
}

void KernelPeer::send_datagram(ByteView datagram) {
  accepted(socket_->send({std::string(kMulticastGroup), kMulticastPort}, datagram));
}

void KernelPeer::close() {
  links_.clear();
  routes_.clear();
}

void KernelPeer::leave() {
  send_raw(header(Routing::kBroadcast, Port::kDeadHost), peis::write(DeadHost{id_, DeathReason::kLost}));
  close();
  listener_.reset();
  announces_ = connects = false;
}

std::vector<std::string> KernelPeer::texts() const {
  std::vector<std::string> texts;
  for (const auto& message : messages) {
    if (message.header.port != Port::kHello) texts.push_back(message.body);
  }
  return texts;
}

std::vector<KernelPeer::Received> KernelPeer::of(Port port) const {
  std::vector<Received> found;
  for (const auto& package : received) {
    if (package.header.port == port) found.push_back(package);
  }
  return found;
}

}  // namespace rubicon::tuples::peis
