#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "apps/simulators/knx/secure_sessions.h"
#include "base/bytes.h"
#include "base/scheduler.h"
#include "networks/knx/wire/description.h"
#include "networks/knx/wire/message.h"
#include "transport/transports.h"

namespace rubicon::knx_simulator {

struct ServerOptions {
  /// Numeric IPv4 address and UDP port to listen on, for TCP too; an empty address = all of the machine's.
  transport::Endpoint at{"127.0.0.1", 3671};
  std::size_t tunnels = 4;
  std::uint16_t first_address = 0x11c8;  ///< of the first tunnel: 1.1.200; the others follow
  std::uint16_t own_address = 0x11fa;    ///< of the server: 1.1.250
  std::string name = "knx-simulator";    ///< in descriptions, at most 30 characters
  bool tcp = true;
  bool wanted_addresses = false;          ///< grants an address that a client requests (Tunnelling version 2)
  bool shares_port = false;               ///< with the sockets of a router on this host
  std::uint16_t data_port = 0;            ///< another UDP port of this host for tunnelled frames; 0 = the same
  std::optional<SecureOptions> secure{};  ///< takes tunnels of KNX IP Secure

  /// One of its tunnels has this address.
  bool is_tunnel(std::uint16_t address) const { return address >= first_address && address < first_address + tunnels; }
};

/// kInvalid: a user of KNX IP Secure has a tunnel that is none of the server's.
Result<void> check_users(const ServerOptions& options);

/// A group telegram that a client sent through its tunnel.
struct ClientFrame {
  SteadyTime when;
  std::uint8_t channel = 0;
  std::uint16_t source = 0;       ///< individual address of the tunnel
  std::uint16_t destination = 0;  ///< group address
  Bytes tpdu;                     ///< from the TPCI byte on: `00 80 0c 33`
  Bytes cemi;                     ///< as received
};

/// A KNXnet/IP tunnelling server (KNX 3/8/2 and 3/8/4; knx.md, sections 3 to 6; knxd.md, section 6) over UDP and TCP.
/// Acknowledges and confirms what clients send, passes it to the other clients and to `on_frame`. Behaves like knxd
/// unless a member below says otherwise. With KNX IP Secure it is strict: a tunnel belongs to one session, and where
/// sessions are required everything plain but searches and descriptions is refused or dropped. TCP connections beyond
/// those of its tunnels and kSpareConnections are closed at once. Scheduler and transports must outlive it.
class Server {
 public:
  /// What happens to datagrams, in each direction (UDP only); probabilities of 0..1.
  struct Weather {
    double loss = 0, duplicate = 0, reorder = 0;
    Duration late = std::chrono::milliseconds(5);  ///< delay of a duplicate or of a datagram that is reordered
    unsigned seed = 1;
  };

  /// TCP connections without a tunnel, such as of clients that it refuses.
  static constexpr std::size_t kSpareConnections = 60;

  Server(Scheduler& scheduler, transport::Transports& transports, ServerOptions options);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// Opens its ports. kBusy if one is taken; else errors as from the transports.
  Result<void> start();
  /// Closes its ports and forgets all tunnels without a message, as when it is killed.
  void stop();
  bool running() const { return socket_ != nullptr; }
  /// Where it listens, with the port that the system chose.
  transport::Endpoint local() const { return socket_ ? socket_->local() : transport::Endpoint(); }

  /// Called for each group telegram of a client.
  std::function<void(const ClientFrame&)> on_frame;
  /// Sends a cEMI frame to all clients.
  void send_to_clients(const Bytes& cemi);

  std::vector<std::uint8_t> channels() const;
  /// Sends DISCONNECT_REQUEST to all clients and forgets their tunnels.
  void disconnect_all();
  /// Forgets all tunnels without a message.
  void forget_all();

  // For tests: faults, and what a client cannot see.

  /// Channel of the next tunnel; then counts up, never 0.
  std::uint8_t next_channel = 1;
  /// Sends raw bytes to all clients on their data endpoints.
  void send_raw(const Bytes& frame);
  /// The same past their secure sessions.
  void send_in_clear(const Bytes& frame);
  /// Open TCP connections.
  std::size_t connections() const { return connections_.size(); }
  /// Adds this to the sequence number of the next request to each client.
  void skip_sequence(std::uint8_t by);
  /// Called for each CONNECT_REQUEST before it is answered; `stream`: received over TCP.
  std::function<void(bool stream)> on_connect;
  bool answers_connect = true;
  std::uint8_t connect_status = 0;   ///< not 0: refuses every CONNECT_REQUEST with this status
  bool only_route_back = false;      ///< as behind NAT: answers to endpoints of HPAIs get lost
  bool disconnects_at_once = false;  ///< ends each tunnel a millisecond after it was opened
  bool answers_heartbeats = true;
  std::uint8_t heartbeat_status = 0;  ///< for known channels
  bool acks = true;
  std::uint8_t ack_status = 0;
  Duration ack_time{};  ///< delay of acknowledgements
  bool confirms = true;
  bool confirms_negatively = false;
  Duration confirm_time{};  ///< delay of L_Data.con; less than ack_time: it precedes the acknowledgement
  /// Answers tunnelling feature 07 and, as its extended search, with this; nullopt: silent, as knxd is. With KNX IP
  /// Secure 254 at first.
  std::optional<std::uint16_t> max_apdu;
  bool listens = true;  ///< false: ignores what it receives
  Weather weather;
  void set_weather(const Weather& change);

  struct Counters {
    std::uint64_t connects = 0, heartbeats = 0, disconnects = 0, requests = 0, repeats_seen = 0, out_of_sequence = 0,
                  acks = 0, dropped_channels = 0, refused_connections = 0, plain_frames = 0;
  };
  Counters counters;
  /// nullptr without KNX IP Secure.
  SecureSessions* sessions() { return sessions_.get(); }

 private:
  struct Connection;
  using ConnectionPtr = std::shared_ptr<Connection>;
  /// A client's end: a UDP endpoint or a TCP connection, and the secure session there (0 = none).
  struct Peer {
    transport::Endpoint udp;
    std::weak_ptr<Connection> tcp;
    bool stream = false;
    std::uint16_t session = 0;
  };
  struct Channel {
    Peer control, data;
    std::uint16_t address = 0;
    std::uint8_t expected = 0, sequence = 0;
    std::deque<Bytes> queue;  ///< cEMI frames; the front one is sent and not yet acknowledged
    unsigned tries = 0;
    Timer ack, silence;
  };
  using Hpai = networks::knx::wire::Hpai;

  Result<std::unique_ptr<transport::UdpSocket>> open_udp(std::uint16_t port);
  Result<void> listen();
  transport::TcpCallbacks accept(std::unique_ptr<transport::TcpStream> stream);
  void lose(const ConnectionPtr& connection);
  void received(const Peer& from, ByteView frame);
  void received_plain(const Peer& from, ByteView frame);
  bool takes_secure(const Peer& from, ByteView bytes);
  bool refuses_plain(const Peer& from, ByteView bytes);
  void session_ended(std::uint16_t session);
  Channel* channel_of(const Peer& from, std::uint8_t id);
  void stream_received(const ConnectionPtr& connection, ByteView bytes);
  void describe(const Peer& from, const Hpai& control);
  void found(const Peer& from, const networks::knx::wire::SearchRequest& request);
  void tell_feature(const Peer& from, const networks::knx::wire::FeatureMessage& request);
  networks::knx::wire::ServerDescription description() const;
  void connect(const Peer& from, const networks::knx::wire::ConnectRequest& request);
  void refuse_connect(const Peer& from, ByteView frame, std::uint8_t status);
  void open_tunnel(const Peer& control, const Peer& data, std::uint16_t address, bool route_back);
  bool in_use(std::uint16_t address) const;
  bool is_reserved(std::uint16_t address, const SecureUser* user) const;
  std::optional<std::uint16_t> address_for(const networks::knx::wire::Cri& cri, std::uint16_t session,
                                           std::uint8_t& status) const;
  void heartbeat(const Peer& from, const networks::knx::wire::ConnectionStateRequest& request);
  void disconnect(const Peer& from, const networks::knx::wire::DisconnectRequest& request);
  void tunnelled(const Peer& from, const networks::knx::wire::ConnectionRequest& request);
  void acknowledge(const Channel& channel, const networks::knx::wire::ConnectionHeader& header);
  void acknowledged(const Peer& from, const networks::knx::wire::ConnectionHeader& header);
  void take_frame(std::uint8_t id, const Bytes& cemi);
  void pass_on(std::uint8_t id, const Bytes& cemi);
  void confirm(std::uint8_t id, const Bytes& cemi);
  void queue(std::uint8_t id, Bytes cemi);
  void send_front(std::uint8_t id);
  void ack_missing(std::uint8_t id);
  void guard_silence(std::uint8_t id);
  void drop(std::uint8_t id);
  Peer peer_of(const Peer& from, const Hpai& hpai) const;
  void send(const Peer& to, const networks::knx::wire::Message& message, bool data = false);
  void transmit(const Peer& to, const Bytes& frame, bool data);
  void transmit_wire(const Peer& to, const Bytes& frame, bool data);
  void later(Duration delay, std::function<void()> call);
  void through_weather(std::function<void()> deliver);
  bool chance(double probability);

  Scheduler& scheduler_;
  transport::Transports& transports_;
  ServerOptions options_;
  std::unique_ptr<transport::UdpSocket> socket_, data_socket_;
  std::unique_ptr<transport::TcpListener> listener_;
  std::vector<ConnectionPtr> connections_;
  std::map<std::uint8_t, Channel> channels_;
  std::unique_ptr<SecureSessions> sessions_;
  std::mt19937 random_{1};
  std::map<std::uint64_t, Timer> pending_;  ///< delayed datagrams and answers
  std::uint64_t last_pending_ = 0;
};

}  // namespace rubicon::knx_simulator
