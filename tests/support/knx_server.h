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

#include "base/bytes.h"
#include "base/scheduler.h"
#include "transport/memory/memory_udp.h"

namespace rubicon::support {

/// A KNXnet/IP server of memory with a bus behind it, for tests: tunnels over UDP and TCP. Written from the
/// specification (knx.md, sections 3 to 6; knxd.md, section 6) with its own codec, so that it shares no mistake with
/// what it tests. Behaves like knxd unless a test says otherwise. The net and the scheduler must outlive it.
class KnxServer {
 public:
  struct Options {
    transport::Endpoint at{"10.0.0.9", 3671};
    std::size_t tunnels = 4;
    std::uint16_t first_address = 0x11c8;  ///< 1.1.200, and so on for the others
    std::uint16_t own_address = 0x11fa;    ///< 1.1.250: who answers reads
    bool tcp = true;
    bool wanted_addresses = false;  ///< knows the extended CRI (Tunnelling version 2)
    /// Data endpoint on another port of this host; 0 = the same.
    std::uint16_t data_port = 0;
  };

  /// A group telegram that reached the bus from a tunnel, in order.
  struct Heard {
    SteadyTime when;
    std::uint8_t channel = 0;
    std::uint16_t source = 0;       ///< address of the tunnel
    std::uint16_t destination = 0;  ///< group address
    Bytes tpdu;                     ///< from the TPCI byte on: `00 80 0c 33`
    Bytes cemi;                     ///< as it came
  };

  /// How badly datagrams fare, each way (UDP only); 0..1 each.
  struct Weather {
    double loss = 0, duplicate = 0, reorder = 0;
    Duration late = std::chrono::milliseconds(5);  ///< how long a reordered datagram stays back, at most
    unsigned seed = 1;
  };

  KnxServer(Scheduler& scheduler, transport::MemoryNet& net) : KnxServer(scheduler, net, Options{}) {}
  KnxServer(Scheduler& scheduler, transport::MemoryNet& net, Options options);
  ~KnxServer();
  KnxServer(const KnxServer&) = delete;
  KnxServer& operator=(const KnxServer&) = delete;

  /// Dies without a word, as at SIGKILL: all tunnels are forgotten. What reached the bus stays known.
  void stop();
  /// Comes back.
  void start();
  bool running() const { return socket_ != nullptr; }

  // The bus.
  const std::vector<Heard>& heard() const { return heard_; }
  /// Called for each telegram that reaches the bus from a tunnel, after it was recorded.
  std::function<void(const Heard&)> on_heard;
  /// A device on the bus writes or answers: `apci` 0x80 or 0x40. Bytes of one below 64 and `small`: the 6 bit form.
  void inject(std::uint16_t source, std::uint16_t group, std::uint8_t apci, const Bytes& value, bool small = false);
  void inject_read(std::uint16_t source, std::uint16_t group);
  /// Any cEMI frame, to all tunnels.
  void inject_cemi(const Bytes& cemi);
  /// Reads of the group are answered so (TPDU data as for inject()), until forgotten.
  struct Answer {
    Bytes value;
    bool small = false;
  };
  std::map<std::uint16_t, Answer> answers;
  Duration answer_time = std::chrono::milliseconds(20);

  // Tunnels.
  std::vector<std::uint8_t> channels() const;
  /// DISCONNECT_REQUEST to all clients; the tunnels are gone.
  void disconnect_all();
  /// Forgets all tunnels without a word.
  void forget_all();
  /// The next channel that is given; goes on from there, never 0.
  std::uint8_t next_channel = 1;
  /// Raw bytes to the clients, on the data path of each tunnel, for frames that are wrong.
  void send_raw(const Bytes& frame);
  /// The sequence number of the next request to clients is moved by so much.
  void skip_sequence(std::uint8_t by);

  // Behaviour, to be set by tests.
  /// Called for each CONNECT_REQUEST before it is answered; `stream`: it came over TCP.
  std::function<void(bool stream)> on_connect;
  bool answers_connect = true;
  std::uint8_t connect_status = 0;   ///< else: this refusal
  bool only_route_back = false;      ///< as behind NAT: what is answered to addresses in HPAIs gets lost
  bool disconnects_at_once = false;  ///< each tunnel, when it is up
  bool answers_heartbeats = true;
  std::uint8_t heartbeat_status = 0;  ///< for known channels
  bool acks = true;
  std::uint8_t ack_status = 0;
  Duration ack_time{};
  bool confirms = true;
  bool confirms_negatively = false;
  Duration confirm_time{};  ///< less than ack_time: the confirmation comes first
  bool listens = true;      ///< else nothing that comes is looked at
  Weather weather;
  void set_weather(const Weather& change);

  struct Counters {
    std::uint64_t connects = 0, heartbeats = 0, disconnects = 0, requests = 0, repeats_seen = 0, out_of_sequence = 0,
                  acks = 0, dropped_channels = 0;
  };
  Counters counters;

 private:
  struct Connection;
  using ConnectionPtr = std::shared_ptr<Connection>;
  /// Where somebody is: an endpoint, or a connection.
  struct Peer {
    transport::Endpoint udp;
    std::weak_ptr<Connection> tcp;
    bool stream = false;
  };
  struct Channel {
    Peer control, data;
    std::uint16_t address = 0;
    std::uint8_t expected = 0, sequence = 0;
    std::deque<Bytes> queue;  ///< cEMI frames; the front one is under way
    unsigned tries = 0;
    Timer ack, silence;
  };

  void received(const Peer& from, ByteView bytes);
  void stream_received(const ConnectionPtr& connection, ByteView bytes);
  void frame(const Peer& from, ByteView bytes);
  void connect_asked(const Peer& from, ByteView body);
  void accept(const Peer& control, const Peer& data, std::uint16_t address, bool route_back);
  std::optional<std::uint16_t> address_for(ByteView cri, std::uint8_t& status) const;
  void on_state(const Peer& from, ByteView body);
  void on_disconnect(const Peer& from, ByteView body);
  void on_request(ByteView body);
  void take(std::uint8_t id, const Bytes& cemi);
  void to_bus(std::uint8_t id, const Bytes& cemi);
  void answer_read(std::uint16_t group);
  void confirm(std::uint8_t id, const Bytes& cemi);
  void on_ack(ByteView body);
  void queue(std::uint8_t id, Bytes cemi);
  void send_front(std::uint8_t id);
  void ack_missing(std::uint8_t id);
  void guard_silence(std::uint8_t id);
  void drop(std::uint8_t id);
  Peer peer_of(const Peer& from, ByteView hpai) const;
  void send(const Peer& to, std::uint16_t service, const Bytes& body, bool data = false);
  void transmit(const Peer& to, const Bytes& frame, bool data);
  void later(Duration delay, std::function<void()> call);
  void through_weather(std::function<void()> deliver);
  bool chance(double probability);

  Scheduler& scheduler_;
  transport::MemoryNet& net_;
  Options options_;
  std::unique_ptr<transport::UdpSocket> socket_, data_socket_;
  std::unique_ptr<transport::MemoryListener> listener_;
  std::vector<ConnectionPtr> connections_;
  std::map<std::uint8_t, Channel> channels_;
  std::vector<Heard> heard_;
  std::mt19937 random_{1};
  std::map<std::uint64_t, Timer> flights_;  ///< what happens later
  std::uint64_t last_flight_ = 0;
};

}  // namespace rubicon::support
