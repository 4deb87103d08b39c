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
  kAcknowledged,  ///< the mote's radio stack has it (wsn.md 9.6); not wanted to be acknowledged: the sink has it
  kNoAnswer,      ///< the sink took it, the mote acknowledged none of the attempts: whether it was executed is unknown
  kSinkSilent,    ///< the sink did not acknowledge it
  kExpired,       ///< its time was over before it could leave
  kRefused,       ///< a recording takes none
  kRejected,      ///< the mote acknowledged it, with an error
  kSuperseded     ///< a newer one about the same came before it was acknowledged
};

struct MoteRequest {
  motes::NetMessage header;  ///< without sequence number (but see `sequence`) and record; `reliable` as it shall be
  Bytes record;              ///< at most kLongestRecord bytes
  sink::Lane lane = sink::Lane::kCommand;
  Duration time_to_live = std::chrono::seconds(5);  ///< until it must have left
  unsigned attempts = 3;                            ///< 1 for what may not be executed twice
  bool harmless = false;                            ///< attempted once, and yet may be executed twice
  std::optional<std::uint16_t> sequence{};          ///< somebody else's
  /// What it is about: a newer one about the same ends it, so that its repetition does not undo the newer one.
  std::optional<std::uint16_t> subject{};
  std::function<void(DeliveryResult)> done{};  ///< called once, in a later turn
};

/// Longest record behind transport and application (wsn.md 12).
inline constexpr std::size_t kLongestRecord = 100;

/// Messages to motes that are acknowledged by the mote: repeated with the same sequence number until it answers (all
/// commands of the firmware may be executed twice, wsn.md 2), so that any attempt's acknowledgement will do.
class MoteRequests {
 public:
  using SendCall = std::function<Result<void>(sink::Outgoing)>;
  /// How long an acknowledgement is waited for once the sink has the message (measured: 46 to 113 ms, wsn.md 2).
  static constexpr Duration kPatience = std::chrono::seconds(1);
  static constexpr std::size_t kMostPending = 4096;

  /// `unanswered`: an attempt that reached the sink was not acknowledged by the mote; may be empty.
  MoteRequests(Scheduler& scheduler, SendCall send, std::function<void()> unanswered = {});

  /// kBusy when too many wait; then `done` is not called.
  Result<void> send(MoteRequest request);
  /// An acknowledgement was heard; false if nobody waits for it.
  bool heard(const motes::HeardAck& ack);

  std::size_t pending() const { return pending_.size(); }
  std::uint64_t unanswered() const { return unanswered_; }

 private:
  using Name = std::pair<std::uint16_t, std::uint16_t>;  ///< mote, sequence number
  struct Pending {
    MoteRequest request;
    SteadyTime expires{};
    unsigned tries = 0;
    bool left = false;  ///< at least once
    std::uint64_t attempt = 0;
    Timer patience;
  };
  std::uint16_t free_sequence(std::uint16_t mote);
  Result<void> put(const Name& name, Pending& pending);
  void sent(const Name& name, std::uint64_t attempt, sink::SendResult outcome);
  void again(Name name);  // by value: the timer that holds it may end with it
  void supersede(const Name& by, std::uint16_t subject);
  void end(Name name, DeliveryResult how);

  Scheduler& scheduler_;
  SendCall send_;
  std::function<void()> unanswered_attempt_;
  std::minstd_rand rng_;
  std::map<Name, Pending> pending_;
  std::uint64_t last_attempt_ = 0, unanswered_ = 0;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::wsn
