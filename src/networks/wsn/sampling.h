#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>

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
class Sampling {
 public:
  /// What of a mote's reports can be believed; nullopt: nobody knows what it reads. `acknowledged`: it follows this;
  /// else it is about to.
  using ToldCall = std::function<void(std::uint16_t mote, std::optional<std::uint16_t> mask, bool acknowledged)>;

  Sampling(Scheduler& scheduler, MoteRequests& requests, SamplingOptions options, ToldCall told);

  /// kBusy when too much waits to be sent; the wish is kept, and told when the mote is heard.
  Result<void> want(std::uint16_t mote, Reads reads);
  /// It was switched on: it reads nothing.
  void joined(std::uint16_t mote);
  /// It was heard; `reported`: with readings.
  void heard(std::uint16_t mote, bool reported);
  /// Somebody else told it (kBroadcast: all of them) what to read: for an hour it is not calmed.
  void overruled(std::uint16_t mote);
  void change(SamplingOptions options) { options_ = options; }

 private:
  struct Mote {
    Reads wish{};
    std::optional<Reads> told;          ///< and acknowledged
    std::optional<Reads> asked;         ///< under way
    std::optional<std::uint16_t> sure;  ///< fresh whichever of the commands it follows that were tried
    bool reports = false;               ///< or did, since it was switched on
    SteadyTime others_until{};          ///< somebody else asked for what it reports
    SteadyTime tried{};
    bool overruled = false;  ///< while it was asked
    unsigned failures = 0;   ///< in a row
    Timer again;
  };
  bool settled(const Mote& mote) const;
  bool may_tell(const Mote& mote) const;
  void tell_later(std::uint16_t address, Mote& mote);
  Result<void> tell(std::uint16_t address, Mote& mote);
  void ended(std::uint16_t address, Delivered how);
  void overrule(std::uint16_t address, Mote& mote);

  Scheduler& scheduler_;
  MoteRequests& requests_;
  SamplingOptions options_;
  ToldCall told_;
  SteadyTime began_;
  SteadyTime all_others_until_{};
  std::size_t calming_ = 0;  ///< under way
  std::map<std::uint16_t, Mote> motes_;
};

}  // namespace rubicon::networks::wsn
