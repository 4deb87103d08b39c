#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "base/scheduler.h"
#include "rubicon/result.hpp"
#include "transport/transports.h"

namespace rubicon::networks::wsn::sink {

/// Where the packets of a sink come from, in the notation of the original (wsn.md 1.3).
struct Source {
  enum class Kind : std::uint8_t {
    kSerial,     ///< `serial@DEVICE:BAUD`: a serial line or pseudo-terminal
    kStream,     ///< `network@HOST:PORT`: the bytes of a serial line over TCP
    kForwarder,  ///< `sf@HOST:PORT`: a serial forwarder that owns the sink
    kFile        ///< `file@PATH`: a packet log, played back
  };
  Kind kind = Kind::kForwarder;
  std::string path;   ///< of kSerial and kFile
  unsigned baud = 0;  ///< of kSerial
  std::string host;   ///< of kStream and kForwarder
  std::uint16_t port = 0;
  std::string record;  ///< the file that `+file@PATH` names: traffic is recorded there; empty: not recorded

  friend bool operator==(const Source&, const Source&) = default;
};

/// Parses a source string; elements are joined by `+` or `>>` (wsn.md 1.3). kInvalid names the faulty part, its
/// position and what was expected; kUnsupported for `tossim-...@` and `peis@`, with the replacement to use.
Result<Source> parse_source(std::string_view text);
/// Without the file to record to: `serial@/dev/ttyUSB0:115200`.
std::string to_string(const Source& source);

/// Priority of a packet, best first. SendQueue lets no lane starve.
enum class Lane : std::uint8_t { kCommand, kClient, kSampling, kProbe };
inline constexpr std::size_t kLanes = 4;

enum class SendResult : std::uint8_t {
  kAcknowledged,     ///< by the sink (wsn.md 9.7); over a forwarder: written to the forwarder
  kNotAcknowledged,  ///< by the sink, after all attempts: the packet may have been executed
  kExpired,          ///< before it could be sent
  kRefused           ///< the source takes no packets (a recording)
};
using SendCallback = std::function<void(SendResult)>;

struct Outgoing {
  Bytes packet;  ///< 1 to 255 bytes, without framing
  Lane lane = Lane::kCommand;
  SteadyTime expires = SteadyTime::max();
  /// False: the packet must not be executed twice, so it is sent only once, acknowledged or not (wsn.md 2, 10).
  bool repeatable = true;
  SendCallback done;  ///< called exactly once, in a later turn, unless the sink is destroyed; may be empty
};

struct SinkState {
  enum class Phase : std::uint8_t { kOff, kConnecting, kUp, kEnded };
  Phase phase = Phase::kOff;
  std::string reason;  ///< for people: "the sink does not acknowledge"; empty if there is nothing to explain
};

/// Called in turns of the loop, never from inside a call to the sink. A callback may destroy the sink, as its last
/// action. Each may be empty.
struct SinkCallbacks {
  std::function<void(const SinkState&)> changed;
  /// The line is lost and closed; open() may be called again. Waiting packets stay in their lanes.
  std::function<void(Error)> failed;
  std::function<void(ByteView packet)> received;
  /// A packet was sent for the first time; not called for its repetitions.
  std::function<void(ByteView packet)> sent;
  /// A lane that refused a packet has room again.
  std::function<void(Lane)> room;
  /// An anomaly for the log, which is counted too; the callee limits it to one line per subject and minute. `subject`
  /// is the name of the counter.
  std::function<void(const std::string& subject, std::string_view text)> note;
};

struct SinkOptions {
  Source source;
  /// The first packet after each opening, sent before all others: its acknowledgement shows that the sink is there
  /// (wsn.md 9.1). Empty: none; the sink is then up as soon as the line is, and a silent sink goes unnoticed.
  Bytes greeting;
  std::size_t lane_size = 128;  ///< packets that may wait in a lane, at least 1
};

/// The connection to one sink over any kind of source. Sends one packet at a time, the next one after the sink
/// acknowledged it (wsn.md 9.7). Waiting packets survive a lost line. Destroying it closes the line.
class Sink {
 public:
  virtual ~Sink() = default;
  /// Starts to connect; phase kUp reports success. Never blocks.
  virtual Result<void> open() = 0;
  /// kBusy: the lane is full, `room` is called later. kRefused: the source is a recording. After an error `done` is not
  /// called. Asserts the size that Outgoing demands.
  virtual Result<void> send(Outgoing packet) = 0;
  virtual const SinkState& state() const = 0;
  /// Counters by name (`[a-z-]+`).
  virtual std::map<std::string, std::uint64_t> counters() const = 0;
};

/// Scheduler and transports must outlive the sink.
std::unique_ptr<Sink> make_sink(SinkOptions options, Scheduler& scheduler, transport::Transports& transports,
                                SinkCallbacks callbacks);

/// Holds the state of a Sink and calls its callbacks. Each of these may destroy the sink, and with it this object:
/// methods that return false were the last thing to happen in it, and their caller must return at once.
class SinkNotifier {
 public:
  explicit SinkNotifier(SinkCallbacks callbacks) : callbacks_(std::move(callbacks)) {}
  SinkNotifier(const SinkNotifier&) = delete;
  SinkNotifier& operator=(const SinkNotifier&) = delete;

  /// For open(): sets the phase without a callback.
  void connecting() { state_ = {SinkState::Phase::kConnecting, {}}; }
  bool set_state(SinkState::Phase phase, std::string reason);
  /// The line is lost: phase kOff with this reason.
  bool failed(Error why);
  /// A packet from the sink. Packets whose dispatch byte is not 00 (serial AM) are counted and discarded (wsn.md 2,
  /// rule 6).
  bool received(ByteView packet);
  /// A packet was sent for the first time.
  bool sent(ByteView packet);
  bool note(const std::string& subject, std::string_view text);
  void room(Lane lane) const;

  const SinkState& state() const { return state_; }
  /// Adds the counters `packets-read`, `packets-written` and `unknown-dispatches`.
  void count(std::map<std::string, std::uint64_t>& into) const;

 private:
  SinkCallbacks callbacks_;
  SinkState state_;
  std::uint64_t read_ = 0, written_ = 0, unknown_dispatches_ = 0;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::wsn::sink
