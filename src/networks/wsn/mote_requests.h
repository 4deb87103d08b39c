#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <random>

#include "base/lifetime.h"
#include "base/scheduler.h"
#include "motes/mote_codec.h"
#include "networks/wsn/sink/sink.h"

namespace rubicon::networks::wsn {

/// How a message to a mote ended.
enum class DeliveryResult : std::uint8_t {
  kAcknowledged,  ///< by the mote's radio stack (wsn.md 9.6); where no acknowledgement was asked for, by the sink
  kNoAnswer,      ///< the sink sent it, the mote acknowledged no attempt: whether it was executed is unknown
  kSinkSilent,    ///< not acknowledged by the sink
  kExpired,       ///< before it could be sent
  kRefused,       ///< the source is a recording
  kRejected,      ///< acknowledged by the mote with an error
  kSuperseded     ///< by a newer message about the same subject, before it was acknowledged
};

struct MoteRequest {
  motes::NetMessage header;  ///< without sequence number and record; `reliable` asks for an acknowledgement
  Bytes record;              ///< at most kMaxRecord bytes
  sink::Lane lane = sink::Lane::kCommand;
  Duration time_to_live = std::chrono::seconds(5);  ///< until it must have been sent
  unsigned attempts = 3;                            ///< 1 for messages that must not be executed twice
  bool idempotent = false;                          ///< may be executed twice although `attempts` is 1
  std::optional<std::uint16_t> sequence{};          ///< of another sender; nullopt: one is chosen
  /// A newer request with the same subject supersedes this one, so that its repetition does not undo the newer one.
  std::optional<std::uint16_t> subject{};
  std::function<void(DeliveryResult)> done{};  ///< called once, in a later turn
};

/// Longest record, without transport and application (wsn.md 12).
inline constexpr std::size_t kMaxRecord = 100;

/// Sends messages to motes and awaits their acknowledgements. Repetitions carry the same sequence number (all commands
/// of the firmware may be executed twice, wsn.md 2), so that the acknowledgement of any attempt counts.
class MoteRequests {
 public:
  using SendCall = std::function<Result<void>(sink::Outgoing)>;
  /// Time for the mote's acknowledgement once the sink has the message (measured: 46 to 113 ms, wsn.md 2).
  static constexpr Duration kAckTimeout = std::chrono::seconds(1);
  static constexpr std::size_t kMaxPending = 4096;

  /// `unanswered` is called for each attempt that the sink sent and the mote did not acknowledge; may be empty.
  MoteRequests(Scheduler& scheduler, SendCall send, std::function<void()> unanswered = {});

  /// kBusy: too many are pending. kDuplicate: the sequence number given is in use. After an error `done` is not called.
  Result<void> send(MoteRequest request);
  /// Takes a mote's acknowledgement; false if no request awaits it.
  bool acknowledged(const motes::HeardAck& ack);

  std::size_t pending() const { return pending_.size(); }
  /// Requests that ended with kNoAnswer.
  std::uint64_t unanswered() const { return unanswered_; }

 private:
  using Key = std::pair<std::uint16_t, std::uint16_t>;  ///< mote, sequence number
  struct Pending {
    MoteRequest request;
    SteadyTime expires{};
    unsigned tries = 0;
    bool reached_sink = false;  ///< at least one attempt did
    std::uint64_t attempt = 0;
    Timer timeout;
  };
  std::uint16_t free_sequence(std::uint16_t mote);
  Result<void> transmit(const Key& key, Pending& pending);
  void sent(const Key& key, std::uint64_t attempt, sink::SendResult result);
  void retry(Key key);  // by value: the timer that holds it may end with it
  void supersede(const Key& by, std::uint16_t subject);
  void end(Key key, DeliveryResult result);

  Scheduler& scheduler_;
  SendCall send_;
  std::function<void()> unanswered_attempt_;
  std::minstd_rand rng_;
  std::map<Key, Pending> pending_;
  std::uint64_t last_attempt_ = 0, unanswered_ = 0;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::wsn
