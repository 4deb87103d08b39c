#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "network/network.h"
#include "networks/knx/dpt/dpt.h"
#include "networks/knx/groups/group_file.h"
#include "networks/knx/problems.h"
#include "rubicon/time.hpp"

namespace rubicon::networks::knx {

/// Which time the clocks on the bus show.
enum class ClockZone : std::uint8_t { kLocal, kUtc };

/// Whether a type is a time of day (10.001), a date (11.001) or both (19.001).
bool is_clock_type(dpt::DptId id);

/// A moment as a clock on the bus shows it. Local: by the time zone of this process (TZ, /etc/localtime), with daylight
/// saving time. 19.001 also says whether that is in force, and whether the clock is set from outside (KNX
/// 3/7/2, 19.001: SUTI, CLQ). kRefused before 2020: the clock of this host was never set, and one on the bus may be
/// right.
Result<wire::Payload> clock_payload(dpt::DptId id, ClockZone zone, WallTime now, bool synchronised);

/// A number that changes when the day or the offset from UTC changes: clocks on the bus are then set at once.
std::int64_t clock_era(ClockZone zone, WallTime now);

/// Whether the system keeps the clock of this host synchronised: adjtimex(2), or, where that is forbidden, the word of
/// systemd-timesyncd.
bool is_clock_synchronised();

/// A tuple that the bus can read and whose changes are written to the bus; or the clock of this host.
struct Exposure {
  wire::GroupAddress address{};
  dpt::DptId dpt;
  std::string tuple;  ///< a key of this island, or `ID:key` of another one; `clock`
  std::optional<ClockZone> clock;
  bool on_change = true;                     ///< the value is written when it changes
  Duration pause = std::chrono::seconds(5);  ///< least time from one write to the next changed value
  std::optional<Duration> every;             ///< the value is also written this often

  friend bool operator==(const Exposure&, const Exposure&) = default;
};

/// Keeps the values of exposed tuples, writes them to the bus and answers reads. The time is sent to clocks when the
/// line is up, when the day or the offset from UTC changes and when the clock of the host is set, within a minute. The
/// host must outlive it.
class Exposures {
 public:
  /// Sends a telegram to the bus; calls `done` with whether it reached the bus, and why it never will (else empty).
  using Send = std::function<void(wire::Telegram, std::function<void(bool sent, std::string_view refused)> done)>;
  /// Called when a value cannot be written (kRefusedExposure), and when an exposure has had no value for kSourceWait
  /// (kNoSource); `over` when it has one again, or is removed.
  struct Report {
    std::function<void(const Problem&)> problem;
    std::function<void(wire::GroupAddress)> over;
  };
  static constexpr Duration kSourceWait = std::chrono::seconds(60);

  Exposures(network::NetworkHost& host, const TypeCatalogue& types, Send send, Report report);

  /// Replaces all exposures. Exposures that are equal to a present one keep their value and timers.
  void set(std::vector<Exposure> exposures);
  /// Writes the known values of all exposures that are written at all.
  void line_up();
  void line_down() { up_ = false; }
  /// Answers a GroupRead in its priority if the value is known. False: the address is not exposed.
  bool answer(const wire::Telegram& read);
  bool contains(wire::GroupAddress address) const;

  std::size_t size() const { return entries_.size(); }
  /// Values and answers that were not written, because their type cannot hold them or the line refused them.
  std::uint64_t refused() const { return refused_; }
  /// Exposures that have had no value for kSourceWait.
  std::size_t without_value() const;

 private:
  struct Entry {
    Exposure exposure;
    std::string text;                      ///< of the tuple; empty = unknown
    std::string status;                    ///< the `.status` beside the value; empty = there is none
    bool usable = true;                    ///< by that status
    bool heard = false;                    ///< the tuple had a value
    bool silent = false;                   ///< reported as without a value
    std::optional<wire::Payload> payload;  ///< nullopt: there is no value to show
    network::TupleWatch value_watch, status_watch;
    Timer cyclic;  ///< the next write by `every`
    Timer source;  ///< until it is reported as without a value
    Timer pause;   ///< while pending, changes wait
    Timer retry;
    std::int64_t era = 0;  ///< clock_era() of the last write of the clock
    bool change_waits = false;
    bool ends = false;        ///< there is no value any more; the change that waits is written first
    bool on_the_way = false;  ///< a telegram waits for its turn, or for its confirmation
  };
  void watch(const std::shared_ptr<Entry>& added, Exposure exposure);
  std::optional<wire::Payload> present(const Entry& entry);
  bool has_value(const Entry& entry) const { return entry.exposure.clock || entry.payload; }
  void look_at_clock();
  void update(Entry& entry);
  void clear(Entry& entry);
  void await_source(Entry& entry);
  void has_source(Entry& entry);
  void refuse(const Entry& entry, std::string_view why);
  void write(Entry& entry);
  void write_change(Entry& entry);
  void written(Entry& entry, bool sent, std::string_view refused);
  void start_pause(Entry& entry);
  void repeat(Entry& entry);
  void retry(Entry& entry);
  Result<wire::Payload> payload_of(const Exposure& exposure, std::string_view text) const;

  network::NetworkHost& host_;
  const TypeCatalogue& types_;
  Send send_;
  Report report_;
  std::uint64_t refused_ = 0;
  bool up_ = false;
  Timer clock_look_;
  Duration clock_offset_{0};  ///< of the wall clock from the steady one, at the last look
  std::vector<std::shared_ptr<Entry>> entries_;
};

}  // namespace rubicon::networks::knx
