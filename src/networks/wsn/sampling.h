#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "base/scheduler.h"
#include "model/message.h"
#include "model/type_catalogue.h"
#include "networks/wsn/outgoing.h"

namespace rubicon::networks::wsn {

/// The properties of motes that TypeCatalogue::device_types() lists: the sampling rate, which the proxy keeps, and the
/// mask of transducers that the mote acknowledged last.
class MoteProperties {
 public:
  /// The catalogue must outlive it.
  explicit MoteProperties(const TypeCatalogue& types) : types_(types) {}

  /// Adds the properties to a mote's join.
  void declare(std::uint16_t mote, model::Join& join) const;
  /// Records the mask that the mote acknowledged; returns the reading to publish.
  model::Updates set_mask(std::uint16_t mote, std::uint16_t mask);

 private:
  const TypeCatalogue& types_;
  std::map<std::uint16_t, std::uint16_t> masks_;  ///< by mote
};

/// Which transducers a mote reads, and how often.
struct SampleSetting {
  std::uint16_t mask = 0;
  std::uint16_t ticks = 65535;  ///< of 1/1024 s (wsn.md 9.4)

  friend bool operator==(const SampleSetting&, const SampleSetting&) = default;
};

/// A period in ticks of the motes' clock, limited to 50 ms .. 64 s (wsn.md 9.4).
std::uint16_t ticks_of(std::chrono::milliseconds period);

struct SamplingOptions {
  std::uint16_t island = 0;
  /// READ_UPDATES to the Control module instead of the periodic command of the released firmware (wsn.md 9.4).
  bool read_updates = false;
};

/// Makes each mote sample what subscribers demand. Sends the command until the mote acknowledges it, and again after
/// the mote was switched on. Without demand a mote is throttled: it reads nothing and reports as seldom as it can (the
/// firmware has no stop). A mote for which there never was a demand is never sent a command, unless it reports.
///
/// Also tracks which fields of a mote's reports were measured. A report carries what the previous tick measured (wsn.md
/// 9.4): the first report after a command has no values of transducers that were not read before, and none at all after
/// the mote was switched on.
class Sampling {
 public:
  struct Callbacks {
    /// Transducers whose values in the mote's next reports were measured; nullopt: unknown.
    std::function<void(std::uint16_t mote, std::optional<std::uint16_t> mask)> measures;
    /// The mote acknowledged that it reads these transducers.
    std::function<void(std::uint16_t mote, std::uint16_t mask)> acknowledged;
  };
  /// `active`: motes that go on sampling for us because they did not acknowledge the command to stop.
  using ClosedCallback = std::function<void(const std::vector<std::uint16_t>& active)>;

  /// Scheduler and requests must outlive it.
  Sampling(Scheduler& scheduler, MoteRequests& requests, SamplingOptions options, Callbacks callbacks);

  /// Sets what is demanded of a mote. kBusy: too many messages wait; the command is sent when the mote is heard.
  /// kUnreachable after close().
  Result<void> demand(std::uint16_t mote, SampleSetting setting);
  /// The mote acknowledged exactly this setting: a repeated demand for it means that its reports are missed.
  bool has_acknowledged(std::uint16_t mote, const SampleSetting& setting) const;
  /// The mote was switched on: it reads nothing.
  void joined(std::uint16_t mote);
  /// A message of the mote arrived; `reported`: with readings.
  void heard(std::uint16_t mote, bool reported);
  /// Another program is about to command the mote (kBroadcast: all motes) to sample; it is not throttled for an hour.
  /// `mask`: of a periodic command; nullopt: the command does not change the periodic reports.
  void override_begins(std::uint16_t mote, std::optional<std::uint16_t> mask);
  /// That command reached the sink with this mask; nullopt: unknown whether it did.
  void override_ends(std::uint16_t mote, std::optional<std::uint16_t> mask);
  void change(SamplingOptions options) { options_ = options; }

  /// The motes that sample for us only.
  std::vector<std::uint16_t> active() const;
  /// Commands these motes to stop, and calls `closed` once, in a later turn, when all acknowledged or `limit` passed.
  /// False: there are none, and `closed` is not called.
  bool close(Duration limit, ClosedCallback closed);

 private:
  struct Mote {
    SampleSetting demanded{};
    std::optional<SampleSetting> acknowledged;
    std::optional<SampleSetting> pending;  ///< command under way
    /// Transducers that it reads in any case, whichever of the commands sent so far it executes; nullopt: unknown.
    std::optional<std::uint16_t> reads;
    std::uint16_t measured = 0;  ///< of these, what its last tick measured
    bool first_report = false;   ///< its next report holds only `measured`
    bool answers = false;        ///< it acknowledged a command since it was switched on
    bool ignores_us = false;     ///< it acknowledged no command: it reports for another program
    bool active = false;         ///< we commanded it to read something
    bool reports = false;        ///< or reported since it was switched on
    SteadyTime last_report{};
    SteadyTime override_until{};  ///< another program asked for its reports
    SteadyTime last_try{};
    bool overridden = false;  ///< while a command of ours was under way
    unsigned failures = 0;    ///< in a row
    Timer retry;
  };
  struct Closing {
    std::deque<std::uint16_t> waiting;
    std::set<std::uint16_t> under_way;
    std::vector<std::uint16_t> active;
    ClosedCallback closed;
    Timer limit;
  };
  bool up_to_date(const Mote& mote) const;
  bool may_command(const Mote& mote) const;
  void retry_later(std::uint16_t address, Mote& mote);
  Result<void> command(std::uint16_t address, Mote& mote);
  void ended(std::uint16_t address, DeliveryResult result);
  void acknowledged(std::uint16_t address, Mote& mote, const SampleSetting& setting);
  void not_acknowledged(std::uint16_t address, Mote& mote, DeliveryResult result);
  void discard_old_measurements(Mote& mote) const;
  void notify_measures(std::uint16_t address, const Mote& mote) const;
  void override_one(std::uint16_t address, Mote& mote, std::optional<std::uint16_t> mask);
  void stop_some();
  void stop_ended(std::uint16_t address, Mote& mote, const SampleSetting& setting, DeliveryResult result);
  void end_closing();

  Scheduler& scheduler_;
  MoteRequests& requests_;
  SamplingOptions options_;
  Callbacks callbacks_;
  SteadyTime started_;
  SteadyTime override_all_until_{};
  std::size_t throttling_ = 0;  ///< commands under way that throttle a mote
  std::map<std::uint16_t, Mote> motes_;
  std::optional<Closing> closing_;
  bool closed_ = false;
};

}  // namespace rubicon::networks::wsn
