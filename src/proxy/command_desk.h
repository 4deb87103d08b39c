#pragma once

#include <functional>
#include <memory>
#include <unordered_map>
#include <vector>

#include "proxy/command.h"
#include "proxy/command_log.h"
#include "proxy/tuple_mirror.h"

namespace rubicon::proxy {

/// Decides about commands inside the reply and follows each one to its end (docs/life-of-a-command.md). What cannot be
/// sent now waits, bounded in number and time. Commands live in memory only: none is ever executed twice.
class CommandDesk {
 public:
  /// `rate_changed`: the one property the proxy executes itself was set.
  CommandDesk(ProxyContext& context, DeviceDirectory& directory, TupleMirror& mirror, Memory& memory,
              std::function<void(Device&)> rate_changed);
  ~CommandDesk();
  CommandDesk(const CommandDesk&) = delete;
  CommandDesk& operator=(const CommandDesk&) = delete;

  /// Somebody requests to set one of the proxy's tuples.
  tuples::SetDecision decide_set(const tuples::RemoteSet& request);
  /// An Actuate or SetProperty of a device, an island or a component, which came as a message: judged as if its sender
  /// had set the tuple. Answered with one Acknowledge once the network has it, or has it not.
  Result<void> take(const Message& message);
  /// Device or line went, or are away for another reason: what waits says so.
  void delayed(Device& device);
  /// The device or its line is back: sends what waits, in order.
  void deliver(Device& device);
  /// True if the request was a command of ours.
  bool acknowledged(const model::Acknowledge& answer);
  /// A good reading of a point with live commands; call after the value was published.
  void reported(Device& device, Point& point, const model::Reading& reading);
  /// The device left, or one of its points vanished: their commands end with them.
  void forget(const Device& device);
  void forget(const Device& device, PointNumber point);

  using Queue = std::vector<std::unique_ptr<Command>>;
  /// The device moves to another island: what was not sent yet comes out, oldest first, of a state the newest only, and
  /// is never executed here.
  Queue release(Device& device);
  /// A command that waited at another island for the device, in the words of its commander; `value` is its text.
  tuples::SetDecision take_over(const tuples::RemoteSet& request, Device& device, Point& point);

 private:
  Result<Point*> target_of(const tuples::RemoteSet& request, Device*& device);
  Result<Point*> target_of(const Message& message, const PointId& id, Device*& device);
  tuples::SetDecision accept(const tuples::RemoteSet& request, Device& device, Point& point);
  tuples::SetDecision accept_elsewhere(const tuples::RemoteSet& request, Device& device, Point& point);
  void take_in();
  void start(std::unique_ptr<Command> command);
  void set_rate(Device& device, Point& point, Command& command);
  void supersede(Device& device, Point& point, const Command& by);
  void dispatch(Device& device, Point& point, Command& command);
  bool is_over(const Command& command) const;
  /// It could not be sent in its time; `why` may be empty.
  void expire(Device& device, Point& point, Command& command, const std::string& why);
  std::chrono::milliseconds time_left(const Command& command) const;
  void wait(Device& device, Point& point, Command& command);
  void sent(Device& device, Point& point, Command& command);
  /// Within the confirmation wait the network must acknowledge, or the device report.
  void await(Command& command);
  void deadline_passed(std::uint64_t serial);
  void change(Device& device, Point& point, Command& command, CommandState state, std::string reason);
  /// Final: publishes the state and drops the command.
  void settle(Device& device, Point& point, Command& command, CommandState state, std::string reason);
  /// Its device or point is gone: there is no state to publish.
  void give_up(Command& command, std::string_view why);
  void answer(Command& command, model::Outcome outcome, std::string_view text);
  void drop(Command& command);
  std::size_t waiting(DeviceNumber device) const;

  ProxyContext& context_;
  DeviceDirectory& directory_;
  TupleMirror& mirror_;
  Memory& memory_;
  std::function<void(Device&)> rate_changed_;
  CommandLog log_;
  base::OncePerTurn next_turn_;
  Queue inbox_;                                             ///< judged in this turn
  std::unordered_map<DeviceNumber, Queue> queues_;          ///< live commands, oldest first
  std::unordered_map<std::uint64_t, Command*> by_request_;  ///< the live ones, by Command::request
  std::size_t live_ = 0;
};

}  // namespace rubicon::proxy
