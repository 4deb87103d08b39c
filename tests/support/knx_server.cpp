#include "support/knx_server.h"

#include <algorithm>
#include <utility>

namespace rubicon::support {

namespace {

using namespace std::chrono_literals;
using transport::Endpoint;

constexpr std::uint16_t kConnectRequest = 0x0205, kConnectResponse = 0x0206, kStateRequest = 0x0207,
                        kStateResponse = 0x0208, kDisconnectRequest = 0x0209, kDisconnectResponse = 0x020a,
                        kTunnellingRequest = 0x0420, kTunnellingAck = 0x0421;
constexpr std::uint8_t kRequest = 0x11, kIndication = 0x29, kConfirmation = 0x2e;
constexpr std::size_t kHpai = 8;

std::uint16_t u16(ByteView bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] << 8 | bytes[at + 1]);
}
std::uint8_t high(std::uint16_t value) {
  return static_cast<std::uint8_t>(value >> 8);
}
std::uint8_t low(std::uint16_t value) {
  return static_cast<std::uint8_t>(value & 0xff);
}

Bytes joined(Bytes first, const Bytes& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

Bytes hpai_of(const Endpoint& at) {
  Bytes bytes{8, 1};
  unsigned part = 0;
  for (const char c : at.address + ".") {
    if (c == '.') {
      bytes.push_back(static_cast<std::uint8_t>(part));
      part = 0;
    } else {
      part = part * 10 + static_cast<unsigned>(c - '0');
    }
  }
  return joined(bytes, {high(at.port), low(at.port)});
}

Bytes data_frame(std::uint8_t code, std::uint16_t source, std::uint16_t group, const Bytes& tpdu) {
  const auto length = static_cast<std::uint8_t>(tpdu.size() - 1);
  const std::uint8_t control = length > 15 ? 0x3c : 0xbc;
  return joined({code, 0, control, 0xe0, high(source), low(source), high(group), low(group), length}, tpdu);
}

Bytes tpdu_of(std::uint8_t apci, const Bytes& value, bool small) {
  if (small) return {0, static_cast<std::uint8_t>(apci | value.at(0))};
  return joined({0, apci}, value);
}

/// Length of L_Data as it should be.
bool well_formed(const Bytes& cemi) {
  return cemi.size() >= 10 && cemi[1] == 0 && cemi.size() == cemi[8] + std::size_t{10};
}

}  // namespace

struct KnxServer::Connection {
  std::unique_ptr<transport::TcpStream> stream;
  Bytes buffer;
};

KnxServer::KnxServer(Scheduler& scheduler, transport::MemoryNet& net, Options options)
    : scheduler_(scheduler), net_(net), options_(std::move(options)) {
  start();
}

KnxServer::~KnxServer() = default;

void KnxServer::set_weather(const Weather& change) {
  weather = change;
  random_.seed(change.seed);
}

void KnxServer::start() {
  if (running()) return;
  transport::UdpCalls calls;
  calls.undelivered = [](const Error&) {};
  calls.failed = [](const Error&) {};
  const auto open = [&](std::uint16_t port) {
    calls.received = [this](const Endpoint& from, ByteView bytes) {
      through_weather([this, from, copy = Bytes(bytes.begin(), bytes.end())] { received({from, {}, false}, copy); });
    };
    transport::UdpOptions udp;
    udp.local = {options_.at.address, port};
    return std::move(net_.open_udp(options_.at.address, udp, calls).value());
  };
  socket_ = open(options_.at.port);
  if (options_.data_port != 0) data_socket_ = open(options_.data_port);
  if (!options_.tcp) return;
  listener_ = net_.tcp.listen(options_.at, [this](std::unique_ptr<transport::TcpStream> stream) {
    auto connection = std::make_shared<Connection>();
    connection->stream = std::move(stream);
    connections_.push_back(connection);
    transport::TcpCalls tcp;
    tcp.received = [this, weak = std::weak_ptr(connection)](ByteView bytes) {
      if (const auto self = weak.lock()) stream_received(self, bytes);
    };
    tcp.failed = [this, weak = std::weak_ptr(connection)](const Error&) {
      std::erase_if(channels_, [&](const auto& entry) {
        return entry.second.control.stream && entry.second.control.tcp.lock() == weak.lock();
      });
      std::erase(connections_, weak.lock());
    };
    return tcp;
  });
}

void KnxServer::stop() {
  flights_.clear();
  socket_.reset();
  data_socket_.reset();
  listener_.reset();
  channels_.clear();
  connections_.clear();
}

// Weather and time.

bool KnxServer::chance(double probability) {
  return probability > 0 && std::uniform_real_distribution<>(0, 1)(random_) < probability;
}

void KnxServer::later(Duration delay, std::function<void()> call) {
  const auto flight = ++last_flight_;
  flights_[flight] = scheduler_.after(delay, [this, flight, call = std::move(call)] {
    const auto landed = flights_.extract(flight);
    call();
  });
}

void KnxServer::through_weather(std::function<void()> deliver) {
  if (chance(weather.loss)) return;
  if (chance(weather.duplicate)) later(weather.late, deliver);
  if (chance(weather.reorder)) return later(weather.late, std::move(deliver));
  deliver();
}

void KnxServer::transmit(const Peer& to, const Bytes& frame, bool data) {
  if (to.stream) {
    if (const auto connection = to.tcp.lock()) (void)connection->stream->send(frame);
    return;
  }
  through_weather([this, to = to.udp, frame, data] {
    if (!running()) return;
    (void)(data && data_socket_ ? *data_socket_ : *socket_).send(to, frame);
  });
}

void KnxServer::send(const Peer& to, std::uint16_t service, const Bytes& body, bool data) {
  const auto total = static_cast<std::uint16_t>(body.size() + 6);
  transmit(to, joined({6, 0x10, high(service), low(service), high(total), low(total)}, body), data);
}

void KnxServer::send_raw(const Bytes& frame) {
  for (const auto& [id, channel] : channels_) transmit(channel.data, frame, true);
}

// Receiving.

void KnxServer::stream_received(const ConnectionPtr& connection, ByteView bytes) {
  auto& buffer = connection->buffer;
  buffer.insert(buffer.end(), bytes.begin(), bytes.end());
  while (buffer.size() >= 6 && buffer.size() >= u16(buffer, 4)) {
    const auto total = std::max<std::uint16_t>(u16(buffer, 4), 6);
    const Bytes one(buffer.begin(), buffer.begin() + total);
    buffer.erase(buffer.begin(), buffer.begin() + total);
    received({{}, connection, true}, one);
  }
}

void KnxServer::received(const Peer& from, ByteView bytes) {
  if (!listens || bytes.size() < 6 || bytes[0] != 6 || bytes[1] != 0x10 || u16(bytes, 4) != bytes.size()) return;
  frame(from, bytes);
}

void KnxServer::frame(const Peer& from, ByteView bytes) {
  const auto body = bytes.subspan(6);
  switch (u16(bytes, 2)) {
    case kConnectRequest: return body.size() >= 2 * kHpai + 2 ? connect_asked(from, body) : void();
    case kStateRequest: return body.size() == 2 + kHpai ? on_state(from, body) : void();
    case kDisconnectRequest: return body.size() == 2 + kHpai ? on_disconnect(from, body) : void();
    case kTunnellingRequest: return body.size() >= 5 && body[0] == 4 ? on_request(body) : void();
    case kTunnellingAck: return body.size() == 4 && body[0] == 4 ? on_ack(body) : void();
    default: return;
  }
}

/// An HPAI, or where it came from.
KnxServer::Peer KnxServer::peer_of(const Peer& from, ByteView hpai) const {
  if (from.stream || u16(hpai, 6) == 0) return from;
  if (only_route_back) return {{"203.0.113.1", 9}, {}, false};
  std::string address;
  for (std::size_t i = 2; i < 6; ++i) address += std::to_string(hpai[i]) + (i < 5 ? "." : "");
  return {{address, u16(hpai, 6)}, {}, false};
}

std::optional<std::uint16_t> KnxServer::address_for(ByteView cri, std::uint8_t& status) const {
  const auto taken = [this](std::uint16_t address) {
    return std::any_of(channels_.begin(), channels_.end(),
                       [=](const auto& entry) { return entry.second.address == address; });
  };
  const auto fail_with = [&status](std::uint8_t code) {
    status = code;
    return std::nullopt;
  };
  const bool extended = cri[0] == 6;
  if (cri[1] != 4 || (extended && !options_.wanted_addresses)) return fail_with(0x22);
  if (cri[2] != 2) return fail_with(0x29);
  if (extended) {
    const auto wanted = u16(cri, 4);
    if (wanted < options_.first_address || wanted >= options_.first_address + options_.tunnels) return fail_with(0x2d);
    if (taken(wanted)) return fail_with(0x2e);
    return wanted;
  }
  for (std::size_t i = 0; i < options_.tunnels; ++i) {
    const auto address = static_cast<std::uint16_t>(options_.first_address + i);
    if (!taken(address)) return address;
  }
  return fail_with(0x24);
}

void KnxServer::connect_asked(const Peer& from, ByteView body) {
  ++counters.connects;
  if (on_connect) on_connect(from.stream);
  if (!answers_connect) return;
  const auto control = peer_of(from, body.first(kHpai)), data = peer_of(from, body.subspan(kHpai, kHpai));
  const auto cri = body.subspan(2 * kHpai);
  std::uint8_t status = connect_status;
  std::optional<std::uint16_t> address;
  if (status == 0 && cri[0] == cri.size() && cri.size() >= 4) address = address_for(cri, status);
  if (!address) return send(control, kConnectResponse, {0, status != 0 ? status : std::uint8_t{0x22}});
  accept(control, data, *address, u16(body, 6) == 0);
}

void KnxServer::accept(const Peer& control, const Peer& data, std::uint16_t address, bool route_back) {
  while (next_channel == 0 || channels_.contains(next_channel)) ++next_channel;
  const auto id = next_channel++;
  auto& channel = channels_[id];
  channel.control = control;
  channel.data = data;
  channel.address = address;
  Bytes hpai{8, static_cast<std::uint8_t>(control.stream ? 2 : 1), 0, 0, 0, 0, 0, 0};
  const auto port = options_.data_port != 0 ? options_.data_port : options_.at.port;
  if (!control.stream && !route_back) hpai = hpai_of({options_.at.address, port});
  send(control, kConnectResponse, joined(joined({id, 0}, hpai), {4, 4, high(address), low(address)}));
  guard_silence(id);
  if (disconnects_at_once) later(1ms, [this] { disconnect_all(); });
}

/// 120 s without a heartbeat end a tunnel.
void KnxServer::guard_silence(std::uint8_t id) {
  channels_[id].silence = scheduler_.after(120s, [this, id] {
    send(channels_[id].control, kDisconnectRequest, {id, 0, 8, 1, 0, 0, 0, 0, 0, 0});
    drop(id);
  });
}

void KnxServer::drop(std::uint8_t id) {
  const auto gone = channels_.extract(id);
}

void KnxServer::on_state(const Peer& from, ByteView body) {
  ++counters.heartbeats;
  if (!answers_heartbeats) return;
  const bool known = channels_.contains(body[0]);
  if (known) guard_silence(body[0]);
  const auto status = known ? heartbeat_status : std::uint8_t{0x21};
  send(peer_of(from, body.subspan(2)), kStateResponse, {body[0], status});
}

void KnxServer::on_disconnect(const Peer& from, ByteView body) {
  ++counters.disconnects;
  const bool known = channels_.contains(body[0]);
  send(peer_of(from, body.subspan(2)), kDisconnectResponse, {body[0], static_cast<std::uint8_t>(known ? 0 : 0x21)});
  drop(body[0]);
}

void KnxServer::on_request(ByteView body) {
  const auto id = body[1], sequence = body[2];
  const auto found = channels_.find(id);
  if (found == channels_.end()) return;
  ++counters.requests;
  auto& channel = found->second;
  const Bytes cemi(body.begin() + 4, body.end());
  if (channel.control.stream) return take(id, cemi);
  const bool again = sequence == static_cast<std::uint8_t>(channel.expected - 1);
  if (sequence != channel.expected && !again) {
    ++counters.out_of_sequence;
    return;
  }
  if (again) ++counters.repeats_seen;
  const std::uint8_t status = ack_status != 0 ? ack_status : well_formed(cemi) ? 0 : 0x29;
  if (acks) {
    const auto ack = [this, to = channel.data, id, sequence, status] {
      send(to, kTunnellingAck, {4, id, sequence, status}, true);
    };
    ack_time == Duration{} ? ack() : later(ack_time, ack);
  }
  const bool refused = status != 0 && status != 0x29;
  if (again || refused) return;
  ++channel.expected;
  if (status == 0) take(id, cemi);
}

// The bus.

void KnxServer::take(std::uint8_t id, const Bytes& cemi) {
  if (!well_formed(cemi) || cemi[0] != kRequest) return;
  if (confirms) confirm(id, cemi);
  to_bus(id, cemi);
}

void KnxServer::confirm(std::uint8_t id, const Bytes& cemi) {
  Bytes confirmation = cemi;
  confirmation[0] = kConfirmation;
  if (confirms_negatively) confirmation[2] |= 1;
  const auto queue_it = [this, id, confirmation] { queue(id, confirmation); };
  confirm_time == Duration{} ? queue_it() : later(confirm_time, queue_it);
}

void KnxServer::to_bus(std::uint8_t id, const Bytes& cemi) {
  Bytes indication = cemi;
  indication[0] = kIndication;
  const auto source = channels_[id].address;
  indication[4] = high(source);
  indication[5] = low(source);
  for (const auto& [other, channel] : channels_) {
    if (other != id) queue(other, indication);
  }
  heard_.push_back({scheduler_.now(), id, source, u16(cemi, 6), Bytes(cemi.begin() + 9, cemi.end()), cemi});
  const Heard copy = heard_.back();
  if (copy.tpdu.size() == 2 && (copy.tpdu[1] & 0xc0) == 0) answer_read(copy.destination);
  if (on_heard) on_heard(copy);
}

void KnxServer::answer_read(std::uint16_t group) {
  if (!answers.contains(group)) return;
  later(answer_time, [this, group] {
    const auto found = answers.find(group);
    if (found != answers.end()) inject(options_.own_address, group, 0x40, found->second.value, found->second.small);
  });
}

void KnxServer::inject(std::uint16_t source, std::uint16_t group, std::uint8_t apci, const Bytes& value, bool small) {
  inject_cemi(data_frame(kIndication, source, group, tpdu_of(apci, value, small)));
}

void KnxServer::inject_read(std::uint16_t source, std::uint16_t group) {
  inject_cemi(data_frame(kIndication, source, group, {0, 0}));
}

void KnxServer::inject_cemi(const Bytes& cemi) {
  for (const auto id : channels()) queue(id, cemi);
}

// Sending to clients: one under way on each tunnel.

void KnxServer::queue(std::uint8_t id, Bytes cemi) {
  const auto found = channels_.find(id);
  if (found == channels_.end()) return;
  auto& channel = found->second;
  channel.queue.push_back(std::move(cemi));
  if (channel.queue.size() == 1) send_front(id);
}

void KnxServer::send_front(std::uint8_t id) {
  auto& channel = channels_[id];
  while (channel.control.stream && !channel.queue.empty()) {
    send(channel.data, kTunnellingRequest, joined({4, id, 0, 0}, channel.queue.front()));
    channel.queue.pop_front();
  }
  if (channel.queue.empty()) return;
  ++channel.tries;
  send(channel.data, kTunnellingRequest, joined({4, id, channel.sequence, 0}, channel.queue.front()), true);
  channel.ack = scheduler_.after(1s, [this, id] { ack_missing(id); });
}

/// Once more, then the tunnel is dropped without a word, as knxd does.
void KnxServer::ack_missing(std::uint8_t id) {
  if (channels_[id].tries < 2) return send_front(id);
  ++counters.dropped_channels;
  drop(id);
}

void KnxServer::on_ack(ByteView body) {
  ++counters.acks;
  const auto found = channels_.find(body[1]);
  if (found == channels_.end()) return;
  auto& channel = found->second;
  if (channel.queue.empty() || body[2] != channel.sequence || body[3] != 0) return;
  channel.ack.cancel();
  channel.queue.pop_front();
  channel.tries = 0;
  ++channel.sequence;
  send_front(body[1]);
}

// Tunnels.

std::vector<std::uint8_t> KnxServer::channels() const {
  std::vector<std::uint8_t> ids;
  for (const auto& [id, channel] : channels_) ids.push_back(id);
  return ids;
}

void KnxServer::disconnect_all() {
  for (const auto id : channels()) {
    send(channels_[id].control, kDisconnectRequest, {id, 0, 8, 1, 0, 0, 0, 0, 0, 0});
    drop(id);
  }
}

void KnxServer::forget_all() {
  channels_.clear();
}

void KnxServer::skip_sequence(std::uint8_t by) {
  for (auto& [id, channel] : channels_) channel.sequence = static_cast<std::uint8_t>(channel.sequence + by);
}

}  // namespace rubicon::support
