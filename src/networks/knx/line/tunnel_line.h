#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/lifetime.h"
#include "networks/knx/line/frame_stream.h"
#include "networks/knx/line/hold_off.h"
#include "networks/knx/line/line.h"
#include "networks/knx/line/outbox.h"
#include "networks/knx/line/tunnel.h"
#include "transport/transports.h"

namespace rubicon::networks::knx::line {

struct TunnelOptions {
  enum class Via : std::uint8_t { kUdp, kTcp };
  /// on: the server answers to the source of our datagrams; auto: only if it does not answer to our own address.
  enum class Nat : std::uint8_t { kAuto, kOn, kOff };
  std::string host;  ///< name or IPv4 address
  std::uint16_t port = 3671;
  std::uint16_t local_port = 0;  ///< of UDP; 0 = any
  Via via = Via::kUdp;
  Nat nat = Nat::kAuto;
  std::optional<wire::IndividualAddress> wanted{};  ///< requested tunnel address; servers of version 1 ignore it
  Outbox::Limits limits{};
};

/// A tunnel to a KNXnet/IP server, over UDP or TCP: connects the state machine Tunnel to sockets and a send queue.
/// After a refusal (no free tunnel, wrong configuration) it waits and retries by itself, in state kWaiting or kRefused;
/// every other loss is reported by `failed`, and the caller reopens.
class TunnelLine final : public Line {
 public:
  /// Scheduler and transports must outlive it.
  TunnelLine(TunnelOptions options, Scheduler& scheduler, transport::Transports& transports, LineCallbacks callbacks);
  ~TunnelLine() override;
  TunnelLine(const TunnelLine&) = delete;
  TunnelLine& operator=(const TunnelLine&) = delete;

  /// Fails if there are no sockets, or if the local port is in use. Does nothing unless the line is off.
  Result<void> open() override;
  bool reopen() override;
  void send(wire::Telegram telegram, SteadyTime expires, SendCallback done) override;
  const LineState& state() const override { return state_; }
  std::map<std::string, std::uint64_t> counters() const override;

 private:
  struct Counters {
    std::uint64_t sent = 0, received = 0, connects = 0, other_source = 0, undelivered = 0, lte = 0, other_frames = 0,
                  duplicate_address = 0,
                  attempts = 0;  ///< to reconnect after a refusal
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

  // Callbacks of the sockets.
  void received(const transport::Endpoint& from, ByteView bytes);
  void stream_received(ByteView bytes);
  void transmit(Tunnel::Path path, ByteView frame);

  // Callbacks of the tunnel.
  void up();
  void received_cemi(ByteView cemi, std::optional<Tunnel::Outcome> outcome);
  void finish(Tunnel::Outcome outcome);
  void count_unconfirmed(Tunnel::Outcome outcome);
  void set_bus(bool connected, std::string_view why);
  void ended(Tunnel::End end);
  bool retries_later(const Tunnel::End& end, Duration lived);

  void pump();
  void note(const std::string& subject, std::string_view text);
  std::string reason_for(const Tunnel::End& end) const;
  void set_state(LineState::Phase phase, std::string reason);
  void retry_after(LineState::Phase phase, Duration pause, std::string why);
  void retry();
  void close_sockets();
  void fail_line(ErrorCode code, std::string why);

  TunnelOptions options_;
  Scheduler& scheduler_;
  transport::Transports& transports_;
  LineCallbacks callbacks_;
  LineState state_;
  bool route_back_;  ///< stays true once it worked
  std::unique_ptr<transport::Lookup> lookup_;
  std::unique_ptr<transport::UdpSocket> socket_;
  std::unique_ptr<transport::TcpStream> stream_;
  std::unique_ptr<Tunnel> tunnel_, retired_;  ///< retired: one of its functions may still be running
  FrameStream frames_;
  transport::Endpoint control_, data_;  ///< of the server
  Timer retry_timer_;
  WallTime next_attempt_{};  ///< when retry_timer_ fires
  HoldOff hold_off_;
  SteadyTime up_since_{};
  std::string send_error_;    ///< of the last failed send since something was received
  std::string other_sender_;  ///< last sender that is not the server, since the sockets were opened
  unsigned unconfirmed_in_row_ = 0;
  TunnelCounters tunnel_counters_;
  Counters counters_;
  Outbox outbox_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::knx::line
