#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "base/scheduler.h"
#include "networks/wsn/sink/source.h"
#include "transport/transports.h"

namespace rubicon::networks::wsn::sink {

/// Who wants a packet sent; an earlier one goes before a later one, but none waits for ever.
enum class Lane : std::uint8_t { kCommand, kClient, kSampling, kProbe };
inline constexpr std::size_t kLanes = 4;

/// What became of a packet.
enum class SendResult : std::uint8_t {
  kAcknowledged,     ///< the sink took it (wsn.md 9.7); by a forwarder: it was handed over
  kNotAcknowledged,  ///< the sink did not acknowledge any of the attempts: it may have executed it
  kExpired,          ///< its time was over before it could leave
  kRefused           ///< the source takes none (a recording)
};
using SendCallback = std::function<void(SendResult)>;

struct Outgoing {
  Bytes packet;  ///< 1 to 255 bytes, no framing
  Lane lane = Lane::kCommand;
  SteadyTime expires = SteadyTime::max();
  /// False for what may not be executed twice: it is sent once, acknowledged or not (wsn.md 2, 10).
  bool repeatable = true;
  SendCallback done;  ///< called exactly once, in a later turn, unless the sink is destroyed; may be empty
};

struct SinkState {
  enum class Phase : std::uint8_t { kOff, kConnecting, kUp, kEnded };
  Phase phase = Phase::kOff;
  std::string reason;  ///< in words: "the sink does not acknowledge"
};

/// Called in turns of the loop, never from inside a call to the sink. The sink, and with it these, may be destroyed in
/// any of them as the last thing it does. Each may be empty.
struct SinkCallbacks {
  std::function<void(const SinkState&)> changed;
  /// The line is lost and closed; open() may be called again. What waits stays in its lanes.
  std::function<void(Error)> failed;
  std::function<void(ByteView packet)> received;
  /// A packet left for the first time (not told again for its repetitions).
  std::function<void(ByteView packet)> left;
  /// A lane that refused a packet has room again.
  std::function<void(Lane)> room;
  /// Something odd that is counted too and worth a line in a log, but not each time: whoever is told keeps to one a
  /// minute for a subject (a counter's name).
  std::function<void(const std::string& subject, std::string_view text)> note;
};

struct SinkOptions {
  Source source;
  /// The first packet after each opening, before all others: its acknowledgement shows that the sink is there
  /// (wsn.md 9.1). Empty = none: then a line is up when it is there, and a sink that answers nothing goes unnoticed.
  Bytes greeting;
  std::size_t lane_size = 128;  ///< packets that may wait in a lane
};

/// The way to one sink, whatever the source: one packet at a time, the next when the sink acknowledged it (wsn.md 9.7).
/// What waits survives a lost line. Destroyed = closed.
class Sink {
 public:
  virtual ~Sink() = default;
  /// Begins to connect; success shows as phase kUp. Never blocks.
  virtual Result<void> open() = 0;
  /// kBusy when the lane is full: `room` tells when it no longer is. kRefused by a recording. Where it fails `done` is
  /// not called. A packet of another size than Outgoing says is asserted.
  virtual Result<void> send(Outgoing packet) = 0;
  virtual const SinkState& state() const = 0;
  /// Counters by name (`[a-z-]+`).
  virtual std::map<std::string, std::uint64_t> counters() const = 0;
};

std::unique_ptr<Sink> make_sink(SinkOptions options, Scheduler& scheduler, transport::Transports& transports,
                                SinkCallbacks calls);

}  // namespace rubicon::networks::wsn::sink
