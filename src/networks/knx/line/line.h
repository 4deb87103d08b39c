#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "networks/knx/secure/group_guard.h"
#include "networks/knx/secure/line_keys.h"
#include "networks/knx/secure/secured_apdu.h"
#include "networks/knx/wire/cemi.h"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::networks::knx::line {

// The telegrams of a line through its guard of secured groups; without a guard they are written and read as they are.

/// The cEMI frame of a telegram that leaves from the address `own`. `max_apdu`: the longest secured APDU that the line
/// carries, in bytes; nullopt = not known. kUnsupported: the telegram is longer once it is secured.
inline Result<Bytes> encode(secure::GroupGuard* guard, wire::CemiCode code, const wire::Telegram& telegram,
                            wire::IndividualAddress own, std::optional<std::uint16_t> max_apdu = {}) {
  if (guard == nullptr) return wire::write_telegram(code, telegram);
  if (max_apdu && guard->secures(telegram.destination)) {
    if (auto fits = secure::fits_secured(telegram, *max_apdu); !fits) return fail(fits.error());
  }
  return guard->protect(code, telegram, own);
}

/// `own`: the present address of the line.
inline secure::GroupGuard::Opened decode(secure::GroupGuard* guard, const wire::DataFrame& frame,
                                         wire::IndividualAddress own) {
  if (guard != nullptr) return guard->open(frame, own);
  auto telegram = wire::to_telegram(frame);
  if (!telegram) return tl::unexpected<secure::GroupGuard::Dropped>(secure::GroupGuard::Dropped{});
  return std::move(*telegram);
}

/// The outcome of a telegram that a line got to send.
enum class SendOutcome : std::uint8_t {
  kSent,             ///< confirmed by L_Data.con; with routing: transmitted
  kNotAcknowledged,  ///< L_Data.con with its error bit: no device on the bus acknowledged it
  kUnconfirmed,      ///< the interface accepted it, but no L_Data.con came within 3 s or before the line was lost
  kRefused,          ///< the server did not understand it (ack status 29), or the queue is full
  kExpired,          ///< it expired before it could be sent
  kLost              ///< the line was lost before its outcome was known, and it was expired or had been repeated before
};

struct LineState {
  enum class Phase : std::uint8_t { kOff, kResolving, kConnecting, kUp, kWaiting, kRefused };
  Phase phase = Phase::kOff;
  std::string reason;             ///< for the user: "all tunnels of the interface are in use (status 24)"
  std::string_view finding{};     ///< for the reason, as Error has it
  std::string server;             ///< name and endpoint, as far as known
  wire::IndividualAddress own{};  ///< the tunnel's address; with routing: the configured one
  bool tunnel_in_use = false;     ///< waits because the interface has no free tunnel for it
  bool user_refused = false;  ///< waits because the interface refuses the password of the user, or has no tunnel for it
  bool bus = true;            ///< false: link up, bus down or silent (status 27, three times no L_Data.con)
  std::string gateway{};      ///< which of several gateways is used, for the user; empty = there is only one
};

/// Called in turns of the loop, never from inside a call to the line. Each call is the last action of the line in its
/// turn, so the line may be destroyed in it. Each may be empty.
struct LineCallbacks {
  std::function<void(const LineState&)> changed;
  /// The line is lost and closed; open() may be called again. Telegrams that wait stay in the line.
  std::function<void(Error)> failed;
  std::function<void(const wire::Telegram&)> received;
  /// Whether a frame of the bus was received before, by another tunnel: it is then dropped.
  std::function<bool(const wire::DataFrame&)> is_known{};
  /// Every cEMI frame in either direction, as transmitted: for monitor and capture.
  std::function<void(ByteView cemi, bool outgoing)> frame;
  /// The outcome of a telegram is known: counters changed.
  std::function<void()> settled;
  /// For the log: an event that a counter counts too. The callee limits it to one line per subject and minute. Subjects
  /// are names of counters, so there are few, whatever arrives from outside.
  std::function<void(const std::string& subject, std::string_view text)> note;
};

using SendCallback = std::function<void(SendOutcome outcome, std::string_view why)>;

/// Calls `settled` of the callbacks, then `done`.
inline SendCallback after_settled(SendCallback done, const LineCallbacks& callbacks) {
  if (!callbacks.settled) return done;
  return [done = std::move(done), settled = callbacks.settled](SendOutcome outcome, std::string_view why) {
    settled();
    if (done) done(outcome, why);
  };
}

/// A connection to the bus: a tunnel over UDP or TCP, or routing. Queues telegrams by priority, sends one at a time and
/// respects the rate of the bus. Telegrams that wait survive a lost line; the one whose outcome is unknown is sent once
/// more unless it has expired. Destruction closes the line, with a DISCONNECT_REQUEST where there is a tunnel.
class Line {
 public:
  virtual ~Line() = default;
  /// Starts to connect; the state becomes kUp on success. Never blocks.
  virtual Result<void> open() = 0;
  /// Ends a pause after a refusal: the line tries again in the next turn. False: there is no pause.
  virtual bool reopen() { return false; }
  /// In a pause because of `tunnel_in_use` or `user_refused`: tries the tunnel of another user at once. Else it does
  /// nothing.
  virtual void use(secure::SessionKeys /*keys*/, wire::IndividualAddress /*tunnel*/) {}
  /// `done` is called exactly once, in a later turn, unless the line is destroyed. Reads use spare rate only.
  virtual void send(wire::Telegram telegram, SteadyTime expires, SendCallback done) = 0;
  virtual const LineState& state() const = 0;
  /// Counters by name (`[a-z-]+`).
  virtual std::map<std::string, std::uint64_t> counters() const = 0;
};

}  // namespace rubicon::networks::knx::line
