#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <random>

#include "base/scheduler.h"
#include "model/message.h"
#include "motes/mote_codec.h"
#include "networks/wsn/mote_messages.h"
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

// Messages from this island to its motes, as requests whose `done` the caller sets.

/// An actuate command (wsn.md 7.1, 9.5). kNotFound: motes have no such actuator. kOutOfRange: the value is not a whole
/// number of 32 bits.
Result<MoteRequest> actuate_request(std::uint16_t island, std::uint16_t mote, std::string_view actuator_type,
                                    const model::Actuate& command);

/// A message that the mote acknowledges and otherwise ignores (wsn.md 9.3). One attempt.
MoteRequest probe_request(std::uint16_t island, std::uint16_t mote);

/// The acknowledgement of a mote's reliable message (wsn.md 9.6).
MoteRequest ack_request(std::uint16_t island, const motes::WantedAck& wanted);

/// An application message of this island, or of a component or mote of another one, whose address it then carries
/// (wsn.md 9.8). kInvalid and kOutOfRange for a faulty tag or record; kRefused: it commands an actuator, which only
/// tuples may do.
Result<MoteRequest> opaque_request(std::uint16_t island, std::uint16_t mote, const model::Message& message,
                                   const MoteTag& tag);

/// A packet of another AM type for the sink itself, outside the motes' network layer (wsn.md 7.2). kRefused: it
/// configures the sink or commands an actuator. kNotFound: it names a device. kOutOfRange: too many bytes.
Result<Bytes> am_packet(const model::Message& message, const MoteTag& tag);

/// A mote's acknowledgement of an application's message with the application's own sequence number (wsn.md 7.2, matrix
/// upload), as a message; nullopt if it acknowledges a command of the firmware.
std::optional<model::Message> acknowledgement_for_applications(const motes::HeardAck& ack);

/// A mote's message of the learning or synaptic layer as `mote/json`; nullopt for other messages.
std::optional<model::Opaque> as_json(const model::Opaque& message);

/// Whether a client's packet may be sent twice: only commands of the firmware may (wsn.md 2).
bool may_repeat(const motes::DecodedPacket& packet);

/// A command to a mote to read transducers.
struct ReadOrder {
  std::uint16_t mote = 0;             ///< kBroadcast: all motes
  std::optional<std::uint16_t> mask;  ///< of the periodic command; nullopt: READ_UPDATES, which does not change it
};
/// nullopt: the message is not such a command.
std::optional<ReadOrder> read_order_in(const motes::RadioMessage& message);
std::optional<ReadOrder> read_order_in(const MoteRequest& request);

/// The result of a message that needs no answer from a mote.
DeliveryResult delivery_result_of(sink::SendResult result);

/// The outcome of request `number` to a mote, with an explanation.
model::Acknowledge acknowledge_of(std::uint64_t number, DeliveryResult result, std::uint16_t mote);

}  // namespace rubicon::networks::wsn
