#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "base/scheduler.h"
#include "networks/knx/line/tunnel_sender.h"
#include "networks/knx/wire/blocks.h"
#include "networks/knx/wire/message.h"

namespace rubicon::networks::knx::line {

/// Asks the server each minute whether it still knows the channel (knx.md, section 5.4). Part of Tunnel.
class TunnelHeartbeat {
 public:
  struct Callbacks {
    std::function<void()> request;                    ///< sends a CONNECTIONSTATE_REQUEST
    std::function<void(std::string why)> unanswered;  ///< no attempt succeeded
  };

  TunnelHeartbeat(Scheduler& scheduler, TunnelCounters& counters, Callbacks callbacks);

  void start();
  void stop() { deadline_.clear(); }
  /// A heartbeat was sent and its answer is due.
  bool awaits_answer() const { return state_ == State::kAwaitsAnswer; }
  /// The server knows the channel, asked by a heartbeat or otherwise.
  void succeeded();
  /// The server answered with another error than that it does not know the channel.
  void failed(std::uint8_t status);

 private:
  enum class State : std::uint8_t { kWaits, kAwaitsAnswer };

  void reached();
  void request();

  TunnelCounters& counters_;
  Callbacks callbacks_;
  State state_ = State::kWaits;
  unsigned attempts_ = 0;
  base::Deadline deadline_;
};

/// One connection to a KNXnet/IP server, from CONNECT_REQUEST to its end: the state machines of tunnelling (KNX 3/8/4;
/// knx.md, sections 5.3 to 6.3), without sockets. Frames enter by receive() and leave by `transmit`. Each callback is
/// the last action of the function that makes it, so the tunnel may be destroyed in `received`, `note` and `ended`, but
/// not in `transmit`.
class Tunnel {
 public:
  enum class Path : std::uint8_t { kControl, kData };  ///< the endpoint of the server that a frame goes to

  using Outcome = TunnelSender::Outcome;

  enum class Cause : std::uint8_t {
    kRefused,         ///< CONNECT_RESPONSE with an error status
    kNoAnswer,        ///< no CONNECT_RESPONSE
    kUnreachable,     ///< the operating system reports that the host or port is unreachable
    kForgotten,       ///< the server no longer knows the channel
    kClosedByServer,  ///< DISCONNECT_REQUEST
    kSilent,          ///< no answer to heartbeats or requests
    kOutOfStep        ///< sequence numbers no longer match
  };
  struct End {
    Cause cause{};
    std::uint8_t status = 0;  ///< of a refusal
    std::string why;          ///< for the user
    /// Of the pending request, if the server is known to have accepted it.
    std::optional<Outcome> outcome;
  };

  struct Callbacks {
    std::function<void(Path, ByteView frame)> transmit;
    std::function<void()> up;
    /// A cEMI frame of any code, in sequence; with an outcome if it ends the pending request.
    std::function<void(ByteView cemi, std::optional<Outcome>)> received;
    /// The pending request ended without its own confirmation.
    std::function<void(Outcome)> finished;
    /// The server reports whether it is connected to the bus: TUNNELLING_FEATURE_INFO or the answer to a heartbeat.
    std::function<void(bool connected)> bus;
    /// Longest APDU that the server carries, in bytes; nullopt: it does not say. After `up`, if it was asked.
    std::function<void(std::optional<std::uint16_t>)> max_apdu{};
    /// As LineCallbacks::note; may be empty.
    std::function<void(const std::string& subject, std::string_view text)> note{};
    /// The last callback.
    std::function<void(End)> ended;
  };

  struct Settings {
    bool stream = false;  ///< TCP: no acks, no repeats, sequence numbers are ignored
    wire::Hpai own{};     ///< where the server sends its answers; route back = to the source of the frames
    /// If the first CONNECT_REQUEST is not answered, all later requests ask for route back. Each request with an
    /// endpoint that the server cannot reach occupies a tunnel of the server until its heartbeat is missing.
    bool tries_route_back = false;
    std::optional<wire::IndividualAddress> wanted{};  ///< requested address; after status 22 or 28 none is
    /// Asks once which APDU the server carries: by tunnelling feature 07 on a stream, else by an extended search, which
    /// costs no sequence number that a server without features would miss (knx.md, section 3.4). idle() waits for it.
    bool asks_max_apdu = false;
  };

  /// The scheduler and the counters must outlive it.
  Tunnel(Scheduler& scheduler, Settings settings, TunnelCounters& counters, Callbacks callbacks);
  Tunnel(const Tunnel&) = delete;
  Tunnel& operator=(const Tunnel&) = delete;

  void connect();
  /// One whole frame.
  void receive(ByteView frame);
  /// The operating system reports that a datagram could not be delivered.
  void undelivered();
  /// The connection below the tunnel broke.
  void lost(std::string why);
  /// An L_Data.req. Only when idle().
  void send(ByteView cemi);
  /// Up and without a pending request.
  bool idle() const { return up() && sender_.idle() && !apdu_deadline_.is_set(); }
  bool up() const { return phase_ == Phase::kUp; }
  /// Sends a DISCONNECT_REQUEST if there is a channel; no callbacks afterwards.
  void close();

  wire::IndividualAddress address() const { return address_; }
  std::uint8_t channel() const { return channel_; }
  /// The endpoint for requests and acks; route back = the control endpoint.
  const wire::Hpai& data_endpoint() const { return data_; }
  /// The server answered a request that asked for route back.
  bool route_back_works() const { return connecting_.answered && !settings_.stream && settings_.own.route_back(); }

 private:
  enum class Phase : std::uint8_t { kNew, kConnecting, kUp, kEnded };

  struct Connecting {
    unsigned attempts = 0;
    SteadyTime until{};
    /// The refusal of the wanted address may arrive more than once; it is ignored until then.
    SteadyTime ignores_refusal_until{};
    bool answered = false;  ///< by any CONNECT_RESPONSE
  };

  // Connecting.
  void send_connect();
  void connect_timeout();
  void connected(const wire::ConnectResponse& response);

  // Frames of the server.
  void receive_control(const wire::Frame& frame);
  void receive_bad_frame(std::string_view why);
  void receive(const wire::ConnectResponse& response);
  void receive(const wire::ConnectionStateResponse& response);
  void receive(const wire::DisconnectRequest& request);
  void receive(const wire::SearchResponse& response);
  void receive_request(const wire::Frame& frame);
  void receive_ack(const wire::Frame& frame);
  void receive_cemi(ByteView cemi);
  void receive_feature(wire::ServiceCode service, ByteView body);
  bool accept_sequence(std::uint8_t sequence);
  bool accept_channel(std::uint8_t channel);
  void refused(std::uint8_t status);

  // Frames to the server.
  void acknowledge(std::uint8_t sequence);
  void request_state();
  void ask_max_apdu();
  void know_max_apdu(std::optional<std::uint16_t> bytes);
  void disconnect(std::uint8_t channel);
  void transmit(Path path, const wire::Message& message);

  void end(Cause cause, std::string why, std::uint8_t status = 0);
  void stop();
  TunnelSender::Callbacks sender_callbacks();
  TunnelHeartbeat::Callbacks heartbeat_callbacks();

  Scheduler& scheduler_;
  Settings settings_;
  TunnelCounters& counters_;
  Callbacks callbacks_;
  Phase phase_ = Phase::kNew;
  Connecting connecting_;
  std::uint8_t channel_ = 0;
  std::uint8_t receive_sequence_ = 0;
  wire::IndividualAddress address_{};
  wire::Hpai data_{};
  Bytes ack_;  ///< its memory is used again
  unsigned undelivered_in_row_ = 0;
  TunnelSender sender_;
  TunnelHeartbeat heartbeat_;
  base::Deadline resync_deadline_, connect_deadline_, apdu_deadline_;
};

}  // namespace rubicon::networks::knx::line
