#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>

#include "networks/knx/wire/telegram.h"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::networks::knx::line {

/// What became of a telegram that was to be sent.
enum class Sent : std::uint8_t {
  kSent,             ///< confirmed by L_Data.con; by routing: it left
  kNotAcknowledged,  ///< L_Data.con with its error bit: nobody on the bus took it
  kUnconfirmed,      ///< the interface took it, but no L_Data.con came within 3 s or before the line was lost
  kRefused,          ///< the server did not understand it (ack status 29), or the queue is full
  kExpired,          ///< its time was over before it could leave
  kLost              ///< the line was lost while it was under way, and again (or its time was over) when repeated
};

struct LineState {
  enum class Phase : std::uint8_t { kOff, kResolving, kConnecting, kUp, kWaiting, kRefused };
  Phase phase = Phase::kOff;
  std::string reason;             ///< in words: "all tunnels of the interface are in use (status 24)"
  std::string server;             ///< name and endpoint, as far as known
  wire::IndividualAddress own{};  ///< the tunnel's address; of routing: the configured one
  bool bus = true;                ///< false: link up, bus down or silent (status 27, three times no con)
};

/// Called in turns of the loop, never from inside a call to the line. The line, and with it these, may be destroyed in
/// any of them as the last thing it does. Each may be empty.
struct LineCalls {
  std::function<void(const LineState&)> changed;
  /// The line is lost and closed; open() may be called again. What waits stays in the line.
  std::function<void(Error)> failed;
  std::function<void(const wire::Telegram&)> received;
  /// Every cEMI frame in either direction, as it stood on the wire: for monitor and capture.
  std::function<void(ByteView cemi, bool outgoing)> frame;
  /// What became of a telegram is known: counters changed.
  std::function<void()> settled;
  /// Something odd that is counted too and worth a line in a log, but not each time: whoever is told keeps to one a
  /// minute for a subject (a counter's name: few, whatever comes from outside).
  std::function<void(const std::string& subject, std::string_view text)> note;
};

using SentCall = std::function<void(Sent outcome, std::string_view why)>;

/// `done` that says `settled` first.
inline SentCall telling(SentCall done, const LineCalls& calls) {
  if (!calls.settled) return done;
  return [done = std::move(done), settled = calls.settled](Sent outcome, std::string_view why) {
    settled();
    if (done) done(outcome, why);
  };
}

/// A way to the bus: a tunnel over UDP or TCP, or routing. Queues by priority, keeps at most one telegram in flight,
/// keeps to the rate of the bus. What waits survives a lost line and is sent once more if its time allows. Destroyed =
/// closed, with a DISCONNECT_REQUEST where there is a tunnel.
class Line {
 public:
  virtual ~Line() = default;
  /// Begins to connect; success shows as state kUp. Never blocks.
  virtual Result<void> open() = 0;
  /// `done` is called exactly once, in a later turn, unless the line is destroyed. Reads use spare rate only.
  virtual void send(wire::Telegram telegram, SteadyTime expires, SentCall done) = 0;
  virtual const LineState& state() const = 0;
  /// Counters by name (`[a-z-]+`).
  virtual std::map<std::string, std::uint64_t> counters() const = 0;
};

}  // namespace rubicon::networks::knx::line
