#pragma once

#include <memory>
#include <string>
#include <vector>

#include "networks/knx/line/frame_stream.h"
#include "networks/knx/line/hold_off.h"
#include "networks/knx/line/line.h"
#include "networks/knx/line/outbox.h"
#include "networks/knx/line/tunnel.h"
#include "transport/transports.h"

namespace rubicon::networks::knx::line {

struct TunnelOptions {
  enum class Via : std::uint8_t { kUdp, kTcp };
  /// on: the server answers to where datagrams come from; auto: so too, if it does not answer to our own address.
  enum class Nat : std::uint8_t { kAuto, kOn, kOff };
  std::string host;  ///< name or IPv4 address
  std::uint16_t port = 3671;
  std::uint16_t local_port = 0;  ///< of UDP; 0 = any
  Via via = Via::kUdp;
  Nat nat = Nat::kAuto;
  std::optional<wire::IndividualAddress> wanted{};  ///< a tunnel address to ask for; servers of version 1 give any
  Outbox::Limits limits{};
};

/// A tunnel to a KNXnet/IP server, over UDP or TCP: binds the state machine to sockets and a queue. Leaves a server
/// alone for a while that has no tunnel to give, or refuses for reasons that stay (then it waits by itself, in state
/// kWaiting or kRefused); every other loss is failed(), and the caller reopens.
class TunnelLine final : public Line {
 public:
  /// Scheduler and transports must outlive it.
  TunnelLine(TunnelOptions options, Scheduler& scheduler, transport::Transports& transports, LineCalls calls);
  ~TunnelLine() override;
  TunnelLine(const TunnelLine&) = delete;
  TunnelLine& operator=(const TunnelLine&) = delete;

  /// Fails if there are no sockets, or the local port is taken. Harmless unless closed.
  Result<void> open() override;
  void send(wire::Telegram telegram, SteadyTime expires, SentCall done) override;
  const LineState& state() const override { return state_; }
  std::map<std::string, std::uint64_t> counters() const override;

 private:
  struct Counters {
    std::uint64_t sent = 0, received = 0, connects = 0, other_source = 0, undelivered = 0, lte = 0, other_frames = 0,
                  doubled_address = 0, attempts = 0;  ///< after a refusal, on our own
  };

  // Connecting.
  void resolved(Result<std::vector<std::string>> addresses);
  void connect();
  Result<void> open_sockets();
  Result<void> open_udp();
  Result<void> open_tcp();
  void make_tunnel();
  wire::Hpai own_endpoint() const;
  bool over_tcp() const { return options_.via == TunnelOptions::Via::kTcp; }

  // What sockets say.
  void received(const transport::Endpoint& from, ByteView bytes);
  void stream_received(ByteView bytes);
  void transmit(Tunnel::Path path, ByteView frame);

  // What the tunnel says.
  void up();
  void received_cemi(ByteView cemi, std::optional<Tunnel::Outcome> outcome);
  void finish(Tunnel::Outcome outcome);
  void count_silence(Tunnel::Outcome outcome);
  void bus_is(bool connected, std::string_view why);
  void ended(Tunnel::End end);
  bool holds_off(const Tunnel::End& end, Duration lived);

  void pump();
  void note(const std::string& subject, std::string_view text);
  std::string reason_of(const Tunnel::End& end) const;
  void set_state(LineState::Phase phase, std::string reason);
  void hold_off(LineState::Phase phase, Duration pause, std::string why);
  void close_sockets();
  void fail_line(ErrorCode code, std::string why);

  TunnelOptions options_;
  Scheduler& scheduler_;
  transport::Transports& transports_;
  LineCalls calls_;
  LineState state_;
  bool route_back_;  ///< once it worked, for good
  std::unique_ptr<transport::Lookup> lookup_;
  std::unique_ptr<transport::UdpSocket> socket_;
  std::unique_ptr<transport::TcpStream> stream_;
  std::unique_ptr<Tunnel> tunnel_, retired_;  ///< retired: may still be in a call
  FrameStream frames_;
  transport::Endpoint control_, data_;  ///< of the server
  Timer pause_;
  WallTime next_attempt_{};  ///< of a pause
  HoldOff hold_off_;
  SteadyTime up_since_{};
  std::string send_error_;  ///< of this machine, since something was heard
  std::string stranger_;    ///< who sent something else than the server, since then
  unsigned silent_ = 0;     ///< telegrams in a row without a confirmation
  TunnelCounters tunnel_counters_;
  Counters counters_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
  Outbox outbox_;
};

}  // namespace rubicon::networks::knx::line
