#include "apps/simulators/knx/server.h"

#include <algorithm>
#include <utility>

#include "networks/knx/wire/blocks.h"
#include "networks/knx/wire/cemi.h"

namespace rubicon::knx_simulator {

namespace {

using namespace std::chrono_literals;
using namespace networks::knx::wire;
using transport::Endpoint;

constexpr std::uint8_t kNoTunnellingLayer = status::kLayer, kRefusedFrame = 0x29;
constexpr std::uint8_t kNoTunnelAddress = 0x2d;  ///< the requested address is none of ours (KNX 3/8/4)
/// Frames that wait for the acknowledgements of a client; more are lost.
constexpr std::size_t kMaxQueued = 1000;

/// L_Data without additional info whose length is right.
bool well_formed(const Bytes& cemi) {
  return cemi.size() >= 10 && cemi[1] == 0 && cemi.size() == cemi[8] + std::size_t{10};
}

}  // namespace

struct Server::Connection {
  std::unique_ptr<transport::TcpStream> stream;
  Bytes buffer;
};

Server::Server(Scheduler& scheduler, transport::Transports& transports, ServerOptions options)
    : scheduler_(scheduler), transports_(transports), options_(std::move(options)) {
  if (!options_.secure) return;
  max_apdu = 254;
  sessions_ = std::make_unique<SecureSessions>(scheduler, *options_.secure, [this](auto id) { session_ended(id); });
}

Server::~Server() = default;

void Server::set_weather(const Weather& change) {
  weather = change;
  random_.seed(change.seed);
}

Result<void> Server::start() {
  if (running()) return {};
  auto socket = open_udp(options_.at.port);
  if (!socket) return fail(socket.error());
  auto data = options_.data_port != 0 ? open_udp(options_.data_port) : Result<std::unique_ptr<transport::UdpSocket>>();
  if (!data) return fail(data.error());
  socket_ = std::move(*socket);
  data_socket_ = std::move(*data);
  auto listening = options_.tcp ? listen() : Result<void>();
  if (!listening) stop();
  return listening;
}

Result<std::unique_ptr<transport::UdpSocket>> Server::open_udp(std::uint16_t port) {
  transport::UdpCallbacks calls;
  calls.undelivered = [](const Error&) {};
  calls.failed = [](const Error&) {};
  calls.received = [this](const Endpoint& from, ByteView bytes) {
    through_weather([this, from, copy = Bytes(bytes.begin(), bytes.end())] { received({from, {}, false, 0}, copy); });
  };
  transport::UdpOptions udp;
  udp.local = {options_.at.address, port};
  udp.reuse_address = options_.shares_port;
  return transports_.open_udp(udp, std::move(calls));
}

Result<void> Server::listen() {
  auto listener = transports_.listen_tcp(
      {options_.at.address, socket_->local().port},
      [this](std::unique_ptr<transport::TcpStream> stream) { return accept(std::move(stream)); });
  if (!listener) return fail(listener.error());
  listener_ = std::move(*listener);
  return {};
}

transport::TcpCallbacks Server::accept(std::unique_ptr<transport::TcpStream> stream) {
  if (connections_.size() >= options_.tunnels + kSpareConnections) {
    ++counters.refused_connections;
    return {};
  }
  auto connection = std::make_shared<Connection>();
  connection->stream = std::move(stream);
  connections_.push_back(connection);
  transport::TcpCallbacks calls;
  calls.received = [this, weak = std::weak_ptr(connection)](ByteView bytes) {
    if (const auto self = weak.lock()) stream_received(self, bytes);
  };
  calls.failed = [this, weak = std::weak_ptr(connection)](const Error&) { lose(weak.lock()); };
  return calls;
}

void Server::lose(const ConnectionPtr& connection) {
  std::erase_if(channels_, [&](const auto& entry) {
    return entry.second.control.stream && entry.second.control.tcp.lock() == connection;
  });
  if (sessions_ && connection) sessions_->lose(connection.get());
  std::erase(connections_, connection);
}

void Server::stop() {
  pending_.clear();
  if (sessions_) sessions_->end_all({});
  socket_.reset();
  data_socket_.reset();
  listener_.reset();
  channels_.clear();
  connections_.clear();
}

// Weather and time.

bool Server::chance(double probability) {
  return probability > 0 && std::uniform_real_distribution<>(0, 1)(random_) < probability;
}

void Server::later(Duration delay, std::function<void()> call) {
  const auto id = ++last_pending_;
  pending_[id] = scheduler_.after(delay, [this, id, call = std::move(call)] {
    const auto keeps_call_alive = pending_.extract(id);
    call();
  });
}

void Server::through_weather(std::function<void()> deliver) {
  if (chance(weather.loss)) return;
  if (chance(weather.duplicate)) later(weather.late, deliver);
  if (chance(weather.reorder)) return later(weather.late, std::move(deliver));
  deliver();
}

void Server::transmit(const Peer& to, const Bytes& frame, bool data) {
  if (to.session == 0) return transmit_wire(to, frame, data);
  const auto wrapped = sessions_->wrap(to.session, frame);
  if (!wrapped.empty()) transmit_wire(to, wrapped, data);
}

void Server::transmit_wire(const Peer& to, const Bytes& frame, bool data) {
  if (to.stream) {
    if (const auto connection = to.tcp.lock()) (void)connection->stream->send(frame);
    return;
  }
  through_weather([this, to = to.udp, frame, data] {
    if (running()) (void)(data && data_socket_ ? *data_socket_ : *socket_).send(to, frame);
  });
}

void Server::send(const Peer& to, const networks::knx::wire::Message& message, bool data) {
  transmit(to, write(message), data);
}

void Server::send_raw(const Bytes& frame) {
  for (const auto& [id, channel] : channels_) transmit(channel.data, frame, true);
}

// Receiving.

void Server::stream_received(const ConnectionPtr& connection, ByteView bytes) {
  auto& buffer = connection->buffer;
  buffer.insert(buffer.end(), bytes.begin(), bytes.end());
  while (true) {
    const auto size = frame_size(buffer);
    if (!size) return lose(connection);
    if (*size == 0 || buffer.size() < *size) return;
    const auto end = buffer.begin() + static_cast<std::ptrdiff_t>(*size);
    const Bytes frame(buffer.begin(), end);
    buffer.erase(buffer.begin(), end);
    received({{}, connection, true, 0}, frame);
  }
}

void Server::received(const Peer& from, ByteView bytes) {
  if (!listens || takes_secure(from, bytes) || refuses_plain(from, bytes)) return;
  received_plain(from, bytes);
}

void Server::received_plain(const Peer& from, ByteView bytes) {
  const auto message = read_message(bytes);
  if (!message) {
    if (message.error().code == ErrorCode::kUnsupported) refuse_connect(from, bytes, status::kConnectionType);
    return;
  }
  if (const auto* description = std::get_if<DescriptionRequest>(&*message)) return describe(from, description->control);
  if (const auto* search = std::get_if<SearchRequest>(&*message)) return found(from, *search);
  if (const auto* feature = std::get_if<FeatureMessage>(&*message)) return tell_feature(from, *feature);
  if (const auto* request = std::get_if<ConnectRequest>(&*message)) return connect(from, *request);
  if (const auto* state = std::get_if<ConnectionStateRequest>(&*message)) return heartbeat(from, *state);
  if (const auto* end = std::get_if<DisconnectRequest>(&*message)) return disconnect(from, *end);
  if (const auto* request = std::get_if<ConnectionRequest>(&*message)) return tunnelled(from, *request);
  if (const auto* ack = std::get_if<ConnectionAck>(&*message)) return acknowledged(from, ack->header);
}

/// Where the HPAI says; where the message came from if it says nothing.
Server::Peer Server::peer_of(const Peer& from, const Hpai& hpai) const {
  if (from.stream || hpai.route_back()) return from;
  if (only_route_back) return {{"203.0.113.1", 9}, {}, false, from.session};
  return {{address_text(hpai), hpai.port}, {}, false, from.session};
}

// Tunnels.

bool Server::in_use(std::uint16_t address) const {
  return std::any_of(channels_.begin(), channels_.end(),
                     [=](const auto& entry) { return entry.second.address == address; });
}

std::optional<std::uint16_t> Server::address_for(const Cri& cri, std::uint16_t session, std::uint8_t& status) const {
  const auto refuse = [&status](std::uint8_t code) {
    status = code;
    return std::nullopt;
  };
  if (cri.type != ConnectionType::kTunnel || (cri.wanted && !options_.wanted_addresses))
    return refuse(status::kConnectionType);
  if (cri.layer != TunnelLayer::kLink) return refuse(kNoTunnellingLayer);
  const auto* user = session == 0 ? nullptr : sessions_->user_of(session);
  const std::uint16_t granted = user == nullptr ? 0 : user->address;
  if (cri.wanted || granted != 0) {
    const auto wanted = cri.wanted ? number(*cri.wanted) : granted;
    if (granted != 0 && wanted != granted) return refuse(status::kUnauthorised);
    if (!options_.is_tunnel(wanted)) return refuse(kNoTunnelAddress);
    if (in_use(wanted)) return refuse(cri.wanted ? status::kAddressInUse : status::kNoMoreConnections);
    return wanted;
  }
  for (std::size_t i = 0; i < options_.tunnels; ++i) {
    const auto address = static_cast<std::uint16_t>(options_.first_address + i);
    if (!in_use(address) && !is_reserved(address, user)) return address;
  }
  return refuse(status::kNoMoreConnections);
}

void Server::connect(const Peer& from, const ConnectRequest& request) {
  ++counters.connects;
  if (on_connect) on_connect(from.stream);
  if (!answers_connect) return;
  const auto control = peer_of(from, request.control), data = peer_of(from, request.data);
  std::uint8_t status = connect_status;
  std::optional<std::uint16_t> address;
  if (status == 0) address = address_for(request.cri, from.session, status);
  if (!address) return send(control, ConnectResponse{0, status});
  open_tunnel(control, data, *address, request.control.port == 0);
}

/// A CONNECT_REQUEST for a type of connection that we do not read.
void Server::refuse_connect(const Peer& from, ByteView frame, std::uint8_t status) {
  const auto request = read_frame(frame);
  if (!request || request->service != ServiceCode::kConnectRequest) return;
  base::ByteReader reader(request->body);
  const auto control = read_hpai(reader);
  if (control && answers_connect) send(peer_of(from, *control), ConnectResponse{0, status});
}

void Server::open_tunnel(const Peer& control, const Peer& data, std::uint16_t address, bool route_back) {
  while (next_channel == 0 || channels_.contains(next_channel)) ++next_channel;
  const auto id = next_channel++;
  auto& channel = channels_[id];
  channel.control = control;
  channel.data = data;
  channel.address = address;
  Hpai hpai;
  if (control.stream) hpai.protocol = HostProtocol::kTcp;
  const auto& data_socket = data_socket_ ? data_socket_ : socket_;
  const bool known = !options_.at.address.empty();
  if (!control.stream && !route_back && known) hpai = udp_hpai(options_.at.address, data_socket->local().port);
  send(control, ConnectResponse{id, 0, hpai, {ConnectionType::kTunnel, IndividualAddress(address)}});
  guard_silence(id);
  if (disconnects_at_once) later(1ms, [this] { disconnect_all(); });
}

/// 120 s without a heartbeat end a tunnel.
void Server::guard_silence(std::uint8_t id) {
  channels_[id].silence = scheduler_.after(120s, [this, id] {
    send(channels_[id].control, DisconnectRequest{id, {}});
    drop(id);
  });
}

void Server::drop(std::uint8_t id) {
  const auto keeps_timers_alive = channels_.extract(id);
}

void Server::heartbeat(const Peer& from, const ConnectionStateRequest& request) {
  ++counters.heartbeats;
  if (!answers_heartbeats) return;
  const bool known = channel_of(from, request.channel) != nullptr;
  if (known) guard_silence(request.channel);
  const auto status = known ? heartbeat_status : status::kUnknownConnection;
  send(peer_of(from, request.control), ConnectionStateResponse{request.channel, status});
}

void Server::disconnect(const Peer& from, const DisconnectRequest& request) {
  ++counters.disconnects;
  const bool known = channel_of(from, request.channel) != nullptr;
  const auto status = known ? status::kOk : status::kUnknownConnection;
  send(peer_of(from, request.control), DisconnectResponse{request.channel, status});
  if (known) drop(request.channel);
}

/// A channel belongs to the session that opened it.
Server::Channel* Server::channel_of(const Peer& from, std::uint8_t id) {
  const auto found = channels_.find(id);
  return found == channels_.end() || found->second.control.session != from.session ? nullptr : &found->second;
}

void Server::tunnelled(const Peer& from, const ConnectionRequest& request) {
  const auto id = request.header.channel, sequence = request.header.sequence;
  auto* const found = channel_of(from, id);
  if (found == nullptr || request.service != ServiceCode::kTunnellingRequest) return;
  ++counters.requests;
  auto& channel = *found;
  const Bytes cemi(request.cemi.begin(), request.cemi.end());
  if (channel.control.stream) return take_frame(id, cemi);
  const bool again = sequence == static_cast<std::uint8_t>(channel.expected - 1);
  if (sequence != channel.expected && !again) {
    ++counters.out_of_sequence;
    return;
  }
  if (again) ++counters.repeats_seen;
  const std::uint8_t status = ack_status != 0 ? ack_status : well_formed(cemi) ? status::kOk : kRefusedFrame;
  acknowledge(channel, {id, sequence, status});
  const bool refused = status != status::kOk && status != kRefusedFrame;
  if (again || refused) return;
  ++channel.expected;
  if (status == status::kOk) take_frame(id, cemi);
}

void Server::acknowledge(const Channel& channel, const ConnectionHeader& header) {
  if (!acks) return;
  const auto ack = [this, to = channel.data, header] {
    send(to, ConnectionAck{ServiceCode::kTunnellingAck, header}, true);
  };
  if (ack_time == Duration{}) return ack();
  later(ack_time, ack);
}

void Server::take_frame(std::uint8_t id, const Bytes& cemi) {
  if (!well_formed(cemi) || CemiCode(cemi[0]) != CemiCode::kDataRequest) return;
  if (confirms) confirm(id, cemi);
  pass_on(id, cemi);
}

void Server::confirm(std::uint8_t id, const Bytes& cemi) {
  Bytes confirmation = cemi;
  confirmation[0] = static_cast<std::uint8_t>(CemiCode::kDataConfirmation);
  if (confirms_negatively) confirmation[2] |= 1;
  if (confirm_time == Duration{}) return queue(id, std::move(confirmation));
  later(confirm_time, [this, id, confirmation] { queue(id, confirmation); });
}

/// To the other clients, and to the bus.
void Server::pass_on(std::uint8_t id, const Bytes& cemi) {
  const auto source = channels_[id].address;
  auto frame = read_data_frame(cemi);
  if (!frame) return;
  const ClientFrame taken{
      scheduler_.now(), id, source, frame->destination, Bytes(frame->tpdu.begin(), frame->tpdu.end()), cemi};
  frame->code = CemiCode::kDataIndication;
  frame->source = IndividualAddress(source);
  const auto indication = networks::knx::wire::write(*frame);
  for (const auto& [other, channel] : channels_) {
    if (other != id) queue(other, indication);
  }
  if (on_frame) on_frame(taken);
}

void Server::send_to_clients(const Bytes& cemi) {
  for (const auto id : channels()) queue(id, cemi);
}

// Sending to clients: at most one frame of a tunnel is unacknowledged.

void Server::queue(std::uint8_t id, Bytes cemi) {
  const auto found = channels_.find(id);
  if (found == channels_.end() || found->second.queue.size() >= kMaxQueued) return;
  auto& channel = found->second;
  channel.queue.push_back(std::move(cemi));
  if (channel.queue.size() == 1) send_front(id);
}

void Server::send_front(std::uint8_t id) {
  auto& channel = channels_[id];
  const auto request = [&](std::uint8_t sequence) {
    return ConnectionRequest{ServiceCode::kTunnellingRequest, {id, sequence, 0}, channel.queue.front()};
  };
  while (channel.control.stream && !channel.queue.empty()) {
    send(channel.data, request(0));
    channel.queue.pop_front();
  }
  if (channel.queue.empty()) return;
  ++channel.tries;
  send(channel.data, request(channel.sequence), true);
  channel.ack = scheduler_.after(1s, [this, id] { ack_missing(id); });
}

/// Repeats the frame once, then drops the tunnel without a message, as knxd does.
void Server::ack_missing(std::uint8_t id) {
  if (channels_[id].tries < 2) return send_front(id);
  ++counters.dropped_channels;
  drop(id);
}

void Server::acknowledged(const Peer& from, const ConnectionHeader& header) {
  ++counters.acks;
  auto* const found = channel_of(from, header.channel);
  if (found == nullptr) return;
  auto& channel = *found;
  if (channel.queue.empty() || header.sequence != channel.sequence || header.status != 0) return;
  channel.ack.cancel();
  channel.queue.pop_front();
  channel.tries = 0;
  ++channel.sequence;
  send_front(header.channel);
}

std::vector<std::uint8_t> Server::channels() const {
  std::vector<std::uint8_t> ids;
  for (const auto& [id, channel] : channels_) ids.push_back(id);
  return ids;
}

void Server::disconnect_all() {
  for (const auto id : channels()) {
    send(channels_[id].control, DisconnectRequest{id, {}});
    drop(id);
  }
}

void Server::forget_all() {
  channels_.clear();
}

void Server::skip_sequence(std::uint8_t by) {
  for (auto& [id, channel] : channels_) channel.sequence = static_cast<std::uint8_t>(channel.sequence + by);
}

}  // namespace rubicon::knx_simulator
