#pragma once

#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "base/scheduler.h"
#include "model/point_tuples.h"
#include "proxy/device.h"
#include "proxy/device_directory.h"
#include "proxy/proxy_config.h"
#include "rubicon/tuple_space.hpp"

namespace rubicon::proxy {

/// The name of a component for people, from its summary: `rubicon set (pid 4711 of anna)`, ` on HOST` with it if that
/// is another one, `flat (island 2)`; `component 70001` if it has no summary. Printable, at most some 200 bytes.
std::string commander_name(const TupleSpace& space, const ProxyConfig& config, OwnerId id);

/// The states of a command (docs/life-of-a-command.md). The first two are live, all others final.
enum class CommandState : std::uint8_t {
  kQueued,      ///< waits for the line, the device, or the acknowledgement of the network
  kSent,        ///< acknowledged by bus or firmware; the device has not reported yet
  kConfirmed,   ///< the device reported the commanded value after it was sent
  kAssumed,     ///< sent to an actuator that never reports
  kRefused,     ///< by the network or the device
  kFailed,      ///< the network could not send it
  kTimedOut,    ///< sent, and not acknowledged or reported in time
  kExpired,     ///< its time to live ended before it could be sent
  kSuperseded,  ///< replaced by a newer command
};
std::string_view to_string(CommandState state);

/// The sender of a command that came as a message: gets one Acknowledge.
struct Asker {
  Address from, about;
  std::uint64_t request = 0;
};

/// One live command, identified by its creator and the request number of the creator. Owned by the CommandDesk.
struct Command {
  DeviceNumber device = 0;
  PointNumber point = 0;
  std::string key;  ///< of its point: `proxy.wsn-1.7.actuator.led-1`
  OwnerId creator{};
  std::uint64_t creator_request = 0;
  std::string commander;       ///< commander_name() of the creator
  std::optional<Asker> asker;  ///< set if it came as a message that is not answered yet
  Value value;
  std::string text;          ///< as published: the text of the value, which may be spelled otherwise in the request
  Duration time_to_live{0};  ///< from when it was accepted
  SteadyTime accepted{}, expires{};
  CommandState state = CommandState::kQueued;
  WallTime since{};
  WallTime until{};  ///< when the state ends by itself; zero = final
  std::string reason;
  std::optional<model::Commander> by;  ///< that superseded it
  std::uint64_t request = 0;           ///< identifies it to the network and to its deadline; changes at each step
  Moment dispatched{};                 ///< when it was sent to the network; zero = it waits for line or device
  model::Outcome outcome = model::Outcome::kSent;  ///< the answer of the network
  Timer deadline;                                  ///< expiry, then the waits for acknowledgement and confirmation

  bool is_dispatched() const { return dispatched.wall != WallTime{}; }
};

/// The JSON of the command in the status of its point.
std::string command_text(const Command& command);

/// Parses the text of a command by the type of the point, within the range that the point declared.
Result<Value> parse_command(const Point& point, std::string_view text);

/// True if the device reports the commanded value; real numbers may differ by the rounding of a 16-bit float (0.1 %).
bool confirms(const Value& reported, const Value& commanded);

/// How the commands of a point ended that its status shows no more, because a newer one came: for a while the status
/// has them beside it, so that each commander finds its own. Several may end between two deliveries of a status.
class KeptOutcomes {
 public:
  /// Of a point, and in all; beyond them the oldest are forgotten, or none is kept.
  static constexpr std::size_t kMaxPerPoint = 256, kMaxInAll = 10'000;
  /// Of the texts of a point; so much stands in each status for a while.
  static constexpr std::size_t kMaxBytes = std::size_t{32} * 1024;
  static constexpr Duration kKept = std::chrono::seconds(10);
  /// Longer reasons are cut, in bytes.
  static constexpr std::size_t kMaxReason = 200;

  using Place = std::pair<DeviceNumber, PointNumber>;
  /// The text that the status of the point has to show from now on.
  using Changed = std::function<void(const Place& place, const std::string& text)>;

  KeptOutcomes(Scheduler& scheduler, Changed changed) : scheduler_(scheduler), changed_(std::move(changed)) {}

  /// The status shows this command now, with its state. Calls Changed if it replaces another one that had ended.
  void shown(const Command& command, bool is_final);
  void forget(const Place& place);
  void forget(DeviceNumber device);

 private:
  struct Kept {
    model::CommandOutcome outcome;
    SteadyTime since{};
  };
  struct OfPoint {
    Kept current;  ///< the one that the status shows
    bool is_final = false;
    std::deque<Kept> ended;  ///< oldest first
    std::size_t bytes = 0;
  };
  using Points = std::map<Place, OfPoint>;

  void drop_oldest(OfPoint& of);
  void keep(OfPoint& of);
  void tell(const Place& place, const OfPoint& of) const;
  void prune();

  Scheduler& scheduler_;
  Changed changed_;
  Points points_;
  std::size_t count_ = 0;  ///< of all `ended`
  base::Deadline next_{scheduler_, [this] { prune(); }};
};

/// Logs one line at info for each accepted command when it ends: commander, value, final state, duration, reason. More
/// than kLines per kWindow are only counted, in one line by final state.
class CommandLog {
 public:
  static constexpr std::size_t kLines = 50;
  static constexpr Duration kWindow = std::chrono::seconds(10);

  explicit CommandLog(ProxyContext& context) : context_(context) {}
  ~CommandLog() { log_omitted(); }
  CommandLog(const CommandLog&) = delete;
  CommandLog& operator=(const CommandLog&) = delete;

  /// `how` is the final state, or `dropped` or `moved` for a command that ended without one.
  void ended(const Command& command, std::string_view how, std::string_view why);

 private:
  void log_omitted();

  ProxyContext& context_;
  SteadyTime begun_ = SteadyTime::min();
  std::size_t logged_ = 0;
  std::map<std::string, std::uint64_t, std::less<>> omitted_;  ///< by final state
  Timer end_;
};

}  // namespace rubicon::proxy
