#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "base/scheduler.h"
#include "networks/knx/wire/message.h"

namespace rubicon::networks::knx::line {

/// Counters of all tunnels that a line has opened one after another.
struct TunnelCounters {
  std::uint64_t repeats = 0;             ///< requests sent a second time
  std::uint64_t missing_acks = 0;        ///< no TUNNELLING_ACK with status 00 in time
  std::uint64_t unconfirmed = 0;         ///< no L_Data.con in time
  std::uint64_t not_acknowledged = 0;    ///< L_Data.con with its error bit
  std::uint64_t not_understood = 0;      ///< TUNNELLING_ACK with status 29
  std::uint64_t late_confirmations = 0;  ///< L_Data.con that belongs to no pending request
  std::uint64_t duplicates = 0;          ///< received again, acknowledged, discarded
  std::uint64_t wrong_sequence = 0;
  std::uint64_t wrong_channel = 0;
  std::uint64_t bad_frames = 0;
  std::uint64_t unknown_services = 0;
  std::uint64_t missing_heartbeats = 0;
};

/// Sends the telegrams of one tunnel, one at a time, and finds out what became of each: the TUNNELLING_ACK, its repeat,
/// and the L_Data.con of the bus (knx.md, section 6.1). Part of Tunnel, which owns it and its counters. Each call is
/// the last action of the function that makes it, except `transmit` and `check_connection`.
class TunnelSender {
 public:
  enum class Outcome : std::uint8_t { kConfirmed, kNotAcknowledged, kUnconfirmed, kNotUnderstood };

  struct Callbacks {
    std::function<void(ByteView frame)> transmit;
    /// Asks the server whether it still knows the channel.
    std::function<void()> check_connection;
    /// The pending request ended without its own confirmation.
    std::function<void(Outcome)> finished;
    /// The server does not respond: the tunnel is useless.
    std::function<void(std::string why)> gave_up;
  };

  /// `stream`: TCP, where requests are neither acknowledged nor repeated.
  TunnelSender(Scheduler& scheduler, bool stream, TunnelCounters& counters, Callbacks callbacks);

  bool idle() const { return state_ == State::kIdle; }
  /// An L_Data.req. Only when idle().
  void send(std::uint8_t channel, ByteView cemi);
  /// A TUNNELLING_ACK of this channel.
  void receive_ack(const wire::ConnectionHeader& ack);
  /// An L_Data.con. Returns the outcome if it ends the pending request.
  std::optional<Outcome> receive_confirmation(ByteView cemi);
  /// The server sent something, whatever it is.
  void server_is_alive();
  /// Abandons the pending request. Returns its outcome if the server is known to have accepted it. Nothing is called.
  std::optional<Outcome> stop();

 private:
  enum class State : std::uint8_t {
    kIdle,
    kAwaitsAck,
    kAwaitsConfirmation,
    kChecksConnection,   ///< the confirmation is late, the server was asked about the channel
    kConnectionChecked,  ///< the server has sent something since; the confirmation may still come
    kServerSilent,       ///< only on a stream: nothing has come since the check
  };

  struct Request {
    Bytes frame;  ///< its memory is used again
    unsigned transmissions = 0;
    /// The confirmation arrived before the ack.
    std::optional<Outcome> early_outcome;
    /// A confirmation was credited to the abandoned request before. It may have been for this one, which is equal.
    bool shares_confirmation = false;

    ByteView cemi() const;
  };

  /// A request that ended without a confirmation, which may still arrive.
  struct Abandoned {
    Bytes cemi;  ///< empty = none
    SteadyTime until{};
  };

  void transmit_request();
  void await_confirmation();
  void timeout();
  void ack_missing();
  void check_connection();
  void finish(Outcome outcome);
  bool confirms_abandoned(ByteView confirmation);
  std::optional<Outcome> outcome_of(ByteView confirmation);

  Scheduler& scheduler_;
  const bool stream_;
  TunnelCounters& counters_;
  Callbacks callbacks_;
  State state_ = State::kIdle;
  std::uint8_t sequence_ = 0;
  Request request_;
  Abandoned abandoned_;
  base::Deadline deadline_;
};

}  // namespace rubicon::networks::knx::line
