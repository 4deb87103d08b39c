#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "base/scheduler.h"
#include "networks/wsn/mote_requests.h"

namespace rubicon::networks::wsn {

/// What a mote is told to read, and how often.
struct Reads {
  std::uint16_t mask = 0;
  std::uint16_t ticks = 65535;  ///< of 1/1024 s (wsn.md 9.4)

  friend bool operator==(const Reads&, const Reads&) = default;
};

/// A period in the motes' milliseconds, which are 1/1024 s: 50 ms to 64 s (wsn.md 9.4).
std::uint16_t ticks_of(std::chrono::milliseconds period);

struct SamplingOptions {
  std::uint16_t island = 0;
  /// READ_UPDATES to the Control module instead of the periodic command of the released firmware (wsn.md 9.4).
  bool read_updates = false;
};

/// Makes each mote report what is demanded of it: tells it, again until it acknowledges, again when it was switched on
/// anew, and to go as slow as it can when nobody demands anything (it knows no stop). A mote that was never told
/// anything is left in peace.
///
/// Follows what of a mote's reports was measured. A report carries what the tick before measured (wsn.md 9.4): the
/// first one after a command has nothing for the transducers that the mote did not read before, and none at all after
/// the mote was switched on.
class Sampling {
 public:
  struct Calls {
    /// What of the mote's next reports was measured; nullopt: nobody knows what it reads.
    std::function<void(std::uint16_t mote, std::optional<std::uint16_t> mask)> measures;
    /// The mote acknowledged that it reads these transducers.
    std::function<void(std::uint16_t mote, std::uint16_t mask)> obeys;
  };
  /// The motes that go on sampling for us because they did not acknowledge that they should stop.
  using ClosedCall = std::function<void(const std::vector<std::uint16_t>& untold)>;

  Sampling(Scheduler& scheduler, MoteRequests& requests, SamplingOptions options, Calls calls);

  /// kBusy when too much waits to be sent; the wish is kept, and told when the mote is heard. kUnreachable once it is
  /// closed.
  Result<void> want(std::uint16_t mote, Reads reads);
  /// The mote acknowledged exactly this: who wants it again misses its reports.
  bool obeys(std::uint16_t mote, const Reads& reads) const;
  /// It was switched on: it reads nothing.
  void joined(std::uint16_t mote);
  /// It was heard; `reported`: with readings.
  void heard(std::uint16_t mote, bool reported);
  /// Somebody else is about to tell it (kBroadcast: all of them) what to read: for an hour it is not calmed. `mask`: of
  /// a periodic command; nullopt where the command leaves the periodic reports alone.
  void overruled(std::uint16_t mote, std::optional<std::uint16_t> mask);
  /// That command reached the sink; nullopt: it is not known whether it did.
  void obeys_others(std::uint16_t mote, std::optional<std::uint16_t> mask);
  void change(SamplingOptions options) { options_ = options; }

  /// The motes that sample for us and for nobody else.
  std::vector<std::uint16_t> woken() const;
  /// Tells them to stop, and calls `closed` once, in a later turn, when all acknowledged or `limit` passed. False, and
  /// no call: there are none.
  bool close(Duration limit, ClosedCall closed);

 private:
  struct Mote {
    Reads wish{};
    std::optional<Reads> told;   ///< and acknowledged
    std::optional<Reads> asked;  ///< under way
    /// What it reads whichever of the commands it follows that were tried; nullopt: nobody knows.
    std::optional<std::uint16_t> reads;
    std::uint16_t measured = 0;  ///< of these, what its last tick measured
    bool first = false;          ///< its next report holds `measured` alone
    bool answers = false;        ///< it acknowledged a command since it was switched on
    bool deaf = false;           ///< it acknowledged none: whatever it reports, somebody else asked for
    bool woken = false;          ///< we told it to read something
    bool reports = false;        ///< or did, since it was switched on
    SteadyTime reported{};
    SteadyTime others_until{};  ///< somebody else asked for what it reports
    SteadyTime tried{};
    bool overruled = false;  ///< while it was asked
    unsigned failures = 0;   ///< in a row
    Timer again;
  };
  struct Closing {
    std::deque<std::uint16_t> waiting;
    std::set<std::uint16_t> under_way;
    std::vector<std::uint16_t> untold;
    ClosedCall closed;
    Timer limit;
  };
  bool settled(const Mote& mote) const;
  bool may_tell(const Mote& mote) const;
  void tell_later(std::uint16_t address, Mote& mote);
  Result<void> tell(std::uint16_t address, Mote& mote);
  void ended(std::uint16_t address, DeliveryResult how);
  void acknowledged(std::uint16_t address, Mote& mote, const Reads& asked);
  void not_acknowledged(std::uint16_t address, Mote& mote, DeliveryResult how);
  void forget_measurements_of_old(Mote& mote) const;
  void believe(std::uint16_t address, const Mote& mote) const;
  void overrule(std::uint16_t address, Mote& mote, std::optional<std::uint16_t> mask);
  void stop_some();
  void stop_ended(std::uint16_t address, Mote& mote, const Reads& asked, DeliveryResult how);
  void end_closing();

  Scheduler& scheduler_;
  MoteRequests& requests_;
  SamplingOptions options_;
  Calls calls_;
  SteadyTime began_;
  SteadyTime all_others_until_{};
  std::size_t calming_ = 0;  ///< under way
  std::map<std::uint16_t, Mote> motes_;
  std::optional<Closing> closing_;
  bool closed_ = false;
};

}  // namespace rubicon::networks::wsn
