#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "networks/knx/line/line.h"
#include "networks/knx/line/pauses.h"
#include "networks/knx/line/telegram_queue.h"
#include "networks/knx/line/tunnel.h"
#include "networks/knx/line/tunnel_sockets.h"
#include "networks/knx/secure/session.h"
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
  /// Keys of KNX IP Secure: everything goes through a session of their user. Without them everything is plain.
  std::optional<secure::SessionKeys> secure{};
  TelegramQueue::Limits limits{};
  std::optional<std::uint16_t> max_apdu{};  ///< longest secured APDU in bytes, whatever the interface says
  secure::GroupGuard* guard = nullptr;      ///< of secured groups; must outlive the line
};

/// A tunnel to a KNXnet/IP server, over UDP or TCP: connects the state machine Tunnel to sockets and a send queue, and
/// puts a secure::Session between tunnel and sockets where TunnelOptions::secure is set. After a refusal (no free
/// tunnel, wrong configuration) it waits and retries by itself, in state kWaiting or kRefused; every other loss is
/// reported by `failed`, and the caller reopens.
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
  void use(secure::SessionKeys keys, wire::IndividualAddress tunnel) override;
  /// The next attempt goes to this server.
  void use_gateway(std::string host, std::optional<secure::SessionKeys> keys,
                   std::optional<wire::IndividualAddress> tunnel);
  /// Gives the telegrams that wait to another line, and sends no more; their callbacks are called by that one.
  void hand_over(TunnelLine& to);
  /// A telegram is on its way: its outcome is not known yet.
  bool sending() const { return telegrams_.in_flight(); }
  void send(wire::Telegram telegram, SteadyTime expires, SendCallback done) override;
  const LineState& state() const override { return state_; }
  std::map<std::string, std::uint64_t> counters() const override;

 private:
  struct Counters {
    std::uint64_t sent = 0, received = 0, connects = 0, other_source = 0, undelivered = 0, lte = 0, other_frames = 0,
                  duplicate_address = 0, other_address = 0,
                  attempts = 0;  ///< to reconnect after a refusal
  };

  // Connecting.
  void resolved(Result<std::vector<std::string>> addresses);
  void connect();
  void begin();
  void make_session();
  void make_tunnel(const wire::Hpai& own);
  bool over_tcp() const { return options_.via == TunnelOptions::Via::kTcp; }
  bool tries_route_back() const { return !over_tcp() && options_.nat == TunnelOptions::Nat::kAuto; }

  // Callbacks of the sockets.
  TunnelSockets::Callbacks socket_callbacks();
  void received(ByteView frame);
  void stranger();
  void sockets_failed(const Error& error);
  void transmit(Tunnel::Path path, ByteView frame);
  void put(Tunnel::Path path, ByteView frame);

  // Callbacks of the session.
  void session_up();
  void session_ended(secure::Session::End end);

  // Callbacks of the tunnel.
  void up();
  void compare_address();
  void received_cemi(ByteView cemi, std::optional<Tunnel::Outcome> outcome);
  void dropped(const secure::GroupGuard::Dropped& frame);
  void finish(Tunnel::Outcome outcome);
  void count_unconfirmed(Tunnel::Outcome outcome);
  void set_bus(bool connected, std::string_view why);
  void ended(Tunnel::End end);
  bool retries_later(const Tunnel::End& end, Duration lived);
  bool retries_session(Duration lived);
  bool retries_closed(Duration lived);
  void retry_password(const secure::Session::End& end);
  void explain_refusal(Tunnel::End& end);
  void settle(const Tunnel::End& end);
  void retire();

  void pump();
  void note(const std::string& subject, std::string_view text);
  std::string reason_for(const Tunnel::End& end) const;
  std::string_view finding_of(const Tunnel::End& end) const;
  void set_state(LineState::Phase phase, std::string reason, std::string_view finding = {});
  void retry_after(LineState::Phase phase, Duration pause, std::string why, std::string_view finding = {});
  void retry();
  void fail_line(Error why);
  void add_session_counters(std::map<std::string, std::uint64_t>& all) const;

  TunnelOptions options_;
  Scheduler& scheduler_;
  transport::Transports& transports_;
  LineCallbacks callbacks_;
  LineState state_;
  bool route_back_;  ///< stays true once it worked
  std::unique_ptr<transport::Lookup> lookup_;
  TunnelSockets sockets_;
  std::unique_ptr<Tunnel> tunnel_, retired_;  ///< retired: one of its functions may still be running
  std::unique_ptr<secure::Session> session_, retired_session_;
  std::optional<secure::Session::End> session_end_;  ///< why the last session ended before its tunnel
  Tunnel::Path path_ = Tunnel::Path::kControl;       ///< of the frame that the session wraps
  std::size_t password_form_ = 0;                    ///< of PasswordKey; stays once it worked
  std::size_t refused_forms_ = 0;                    ///< in this round of attempts
  std::optional<std::uint16_t> max_apdu_;            ///< of the interface, in bytes, if it says so
  bool retires_ = false;                             ///< hand_over() was called
  Timer retry_timer_, send_failure_;
  WallTime next_attempt_{};  ///< when retry_timer_ fires
  HoldOff hold_off_;
  SteadyTime up_since_{};
  unsigned unconfirmed_in_row_ = 0;
  TunnelCounters tunnel_counters_;
  secure::SessionCounters session_counters_;
  Counters counters_;
  TelegramQueue telegrams_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::knx::line
