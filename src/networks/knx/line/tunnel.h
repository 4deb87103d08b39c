#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "base/deadline.h"
#include "base/scheduler.h"
#include "networks/knx/wire/message.h"
#include "networks/knx/wire/status.h"

namespace rubicon::networks::knx::line {

/// What happened on a tunnel; kept by who makes tunnels, beyond the life of each.
struct TunnelCounters {
  std::uint64_t repeats = 0;             ///< requests sent once more
  std::uint64_t missing_acks = 0;        ///< no (good) TUNNELLING_ACK in time
  std::uint64_t unconfirmed = 0;         ///< no L_Data.con in time
  std::uint64_t not_acknowledged = 0;    ///< L_Data.con with its error bit
  std::uint64_t not_understood = 0;      ///< ack status 29
  std::uint64_t late_confirmations = 0;  ///< L_Data.con of nothing under way
  std::uint64_t duplicates = 0;          ///< received once more, acknowledged, dropped
  std::uint64_t wrong_sequence = 0;
  std::uint64_t wrong_channel = 0;
  std::uint64_t bad_frames = 0;
  std::uint64_t unknown_services = 0;
  std::uint64_t missing_heartbeats = 0;
};

/// One connection to a KNXnet/IP server, from CONNECT_REQUEST to its end: the state machines of tunnelling (KNX 3/8/4;
/// knx.md, sections 5.3 to 6.3), without sockets. Frames go in by receive() and out by the calls. Calls are made as the
/// last thing of whatever causes them, so the tunnel may be destroyed in `received` and `ended`, but not in `transmit`.
class Tunnel {
 public:
  enum class Path : std::uint8_t { kControl, kData };  ///< which endpoint of the server a frame goes to

  /// What became of the request under way.
  enum class Outcome : std::uint8_t { kConfirmed, kNotAcknowledged, kUnconfirmed, kNotUnderstood };

  enum class Cause : std::uint8_t {
    kRefused,         ///< CONNECT_RESPONSE with a status
    kNoAnswer,        ///< no CONNECT_RESPONSE
    kUnreachable,     ///< the network says that nobody is there
    kForgotten,       ///< the server does not know the channel any more
    kClosedByServer,  ///< DISCONNECT_REQUEST
    kSilent,          ///< no answer to heartbeats, or to requests
    kOutOfStep        ///< sequence numbers do not fit any more
  };
  struct End {
    Cause cause{};
    std::uint8_t status = 0;  ///< of a refusal
    std::string why;          ///< in words
    /// Of a request that was under way, if the server took it for sure.
    std::optional<Outcome> outcome;
  };

  struct Calls {
    std::function<void(Path, ByteView frame)> transmit;
    std::function<void()> up;
    /// A cEMI frame came in sequence, any code; with an outcome if it ends the request under way.
    std::function<void(ByteView cemi, std::optional<Outcome>)> received;
    /// The request under way ended otherwise.
    std::function<void(Outcome)> finished;
    /// TUNNELLING_FEATURE_INFO or a heartbeat tells of the bus connection.
    std::function<void(bool connected)> bus;
    /// As LineCalls::note; may be empty. The tunnel may be destroyed in it.
    std::function<void(const std::string& subject, std::string_view text)> note{};
    /// No more calls after it.
    std::function<void(End)> ended;
  };

  struct Settings {
    bool stream = false;  ///< TCP: no acks, no repeats, sequence numbers are not looked at
    wire::Hpai own{};     ///< what the server shall answer to; route back = to where the frames come from
    /// Without an answer to the first CONNECT_REQUEST the next ones ask for route back, and so does all that follows:
    /// each request with an endpoint that cannot be reached costs a tunnel of the server until it misses the heartbeat.
    bool tries_route_back = false;
    std::optional<wire::IndividualAddress> wanted{};  ///< asked for; without it again on status 22
  };

  Tunnel(Scheduler& scheduler, Settings settings, TunnelCounters& counters, Calls calls);
  Tunnel(const Tunnel&) = delete;
  Tunnel& operator=(const Tunnel&) = delete;

  void connect();
  /// One whole frame.
  void receive(ByteView frame);
  /// The network says that a frame could not be delivered.
  void undelivered();
  /// The way to the server broke.
  void lost(std::string why);
  /// An L_Data.req. Only when idle().
  void send(ByteView cemi);
  /// Up, and nothing under way.
  bool idle() const { return phase_ == Phase::kUp && sending_ == Sending::kIdle; }
  bool up() const { return phase_ == Phase::kUp; }
  /// DISCONNECT_REQUEST if there is a channel; no calls afterwards.
  void close();

  wire::IndividualAddress address() const { return address_; }
  std::uint8_t channel() const { return channel_; }
  /// Where requests and acks go; route back = as control.
  const wire::Hpai& data_endpoint() const { return data_; }
  /// The server answered, and it was asked for route back.
  bool route_back_works() const { return answered_ && !settings_.stream && settings_.own.route_back(); }

 private:
  enum class Phase : std::uint8_t { kNew, kConnecting, kUp, kEnded };
  enum class Sending : std::uint8_t { kIdle, kWaitAck, kWaitConfirmation };

  void send_connect();
  void connect_timeout();
  void on_control(const wire::Frame& frame);
  void bad_frame(std::string_view why);
  void on(const wire::ConnectResponse& response);
  void on(const wire::ConnectionStateResponse& response);
  void on(const wire::DisconnectRequest& request);
  void connected(const wire::ConnectResponse& response);
  void on_request(const wire::Frame& frame);
  void on_ack(const wire::Frame& frame);
  bool in_sequence(std::uint8_t sequence);
  void on_cemi(ByteView cemi);
  void on_feature(wire::ServiceCode service, ByteView body);
  std::optional<Outcome> confirmation(ByteView cemi);
  bool is_stray(ByteView confirmation);
  std::optional<Outcome> acknowledged();
  void ack_missing();
  void request_timeout();
  void transmit_request();
  void acknowledge(std::uint8_t sequence);
  void finish(Outcome outcome);
  void heartbeat();
  void heartbeat_missing();
  void send_state_request();
  void disconnect(std::uint8_t channel);
  void end(Cause cause, std::string why, std::uint8_t code = 0);
  void stop();
  void transmit(Path path, const wire::Message& message);

  Scheduler& scheduler_;
  Settings settings_;
  TunnelCounters& counters_;
  Calls calls_;
  Phase phase_ = Phase::kNew;
  Sending sending_ = Sending::kIdle;
  std::uint8_t channel_ = 0;
  std::uint8_t send_sequence_ = 0, receive_sequence_ = 0;
  wire::IndividualAddress address_{};
  wire::Hpai data_{};
  Bytes request_, ack_;  ///< frames; their memory is used again
  unsigned connect_tries_ = 0, request_tries_ = 0, heartbeat_tries_ = 0, undelivered_in_row_ = 0;
  SteadyTime connect_until_{};
  SteadyTime answers_from_{};     ///< a refusal of the wanted address may come more than once: until then
  std::optional<Outcome> early_;  ///< the confirmation came before the ack
  Bytes stray_;                   ///< cEMI of a request whose confirmation may still come; empty = none
  SteadyTime stray_until_{};
  bool swallowed_ = false;     ///< one such came while an equal request was under way: whose was it?
  bool doubted_ = false;       ///< the server was asked whether it knows the channel, for want of a confirmation
  bool heard_ = false;         ///< anything, since then
  bool holds_ = false;         ///< a stream that is silent: nothing is sent until something is heard
  bool awaits_state_ = false;  ///< a heartbeat is under way
  bool answered_ = false;      ///< by a CONNECT_RESPONSE
  base::Deadline request_deadline_, heartbeat_deadline_, resync_deadline_, connect_deadline_;
};

}  // namespace rubicon::networks::knx::line
