#pragma once

#include <functional>
#include <memory>
#include <unordered_map>
#include <vector>

#include "proxy/command.h"
#include "proxy/tuple_mirror.h"

namespace rubicon::proxy {

/// Accepts or refuses commands inside the reply and tracks each one to its final state (docs/life-of-a-command.md).
/// Commands that cannot be sent now wait, bounded in number and time. They are kept in memory only: none is executed
/// twice.
class CommandDesk {
 public:
  /// `rate_changed`: `rate`, the property that the proxy executes itself, was set.
  CommandDesk(ProxyContext& context, DeviceDirectory& directory, TupleMirror& mirror, Memory& memory,
              std::function<void(Device&)> rate_changed);
  ~CommandDesk();
  CommandDesk(const CommandDesk&) = delete;
  CommandDesk& operator=(const CommandDesk&) = delete;

  /// A remote set of one of the proxy's tuples.
  tuples::SetDecision decide_set(const tuples::RemoteSet& request);
  /// An Actuate or SetProperty that came as a message of a device, an island or a component: treated as if its sender
  /// had set the tuple. Answered with one Acknowledge once the network acknowledged it, or the command ended.
  /// `through`: Gateway::CommandCall.
  Result<void> on_message(const Message& message, const std::string& through = {});
  /// Gateway::MayCommand. Where the device has no such point: whether the sender may know of the device.
  bool may_command(const Message& message);
  /// Device or line is unavailable, or for another reason than before: publishes why commands wait.
  void delayed(Device& device);
  /// The device or its line is back: sends the waiting commands, in order.
  void deliver(Device& device);
  /// True if the answer belongs to a command.
  bool acknowledged(const model::Acknowledge& answer);
  /// A good reading of a point with live commands. Call after its value was published.
  void reported(Device& device, Point& point, const model::Reading& reading);
  /// The device or one of its points is removed: ends its commands.
  void forget(const Device& device);
  void forget(const Device& device, PointNumber point);

  using Queue = std::vector<std::unique_ptr<Command>>;
  /// The device moves to another island: removes and returns the commands that were not sent yet, oldest first; of a
  /// state only the newest.
  Queue release(Device& device);
  /// A command that waited for the device at another island. `from` and `request` name its commander and the
  /// commander's request.
  tuples::SetDecision take_over(const tuples::RemoteSet& request, Device& device, Point& point);

 private:
  Result<Point*> resolve_target(const tuples::RemoteSet& request, Device*& device);
  Result<Point*> resolve_target(const Message& message, const PointId& id, Device*& device);
  tuples::SetDecision accept(const tuples::RemoteSet& request, Device& device, Point& point);
  Result<void> refuse_unresolved(const Message& message, const std::string& through, const Device* device,
                                 const Error& why) const;
  bool knows(const Message& message, const std::string& device) const;
  tuples::SetDecision accept_judged(const Message& message, const std::string& through,
                                    const tuples::RemoteSet& request, Device& device, Point& point);
  tuples::SetDecision accept_under_other_key(const tuples::RemoteSet& request, Device& device, Point& point);
  void start_accepted();
  void start(std::unique_ptr<Command> command);
  void set_rate(Device& device, Point& point, Command& command);
  void supersede(Device& device, Point& point, const Command& by);
  void dispatch(Device& device, Point& point, Command& command);
  bool is_over(const Command& command) const;
  bool is_newer(WallTime measured, const Command& command) const;
  /// The time to live ended before it was sent; `why` may be empty.
  void expire(Device& device, Point& point, Command& command, const std::string& why);
  Duration answer_wait(const Device& device) const;
  std::chrono::milliseconds time_left(const Device& device, const Command& command) const;
  void wait(Device& device, Point& point, Command& command);
  void sent(Device& device, Point& point, Command& command);
  /// Starts the wait for the acknowledgement of the network, or for the report of the device.
  void await(Command& command, Duration wait);
  void deadline_passed(std::uint64_t serial);
  void show_ended(const KeptOutcomes::Place& place, const std::string& text);
  void change(Device& device, Point& point, Command& command, CommandState state, std::string reason);
  /// Publishes a final state and drops the command.
  void settle(Device& device, Point& point, Command& command, CommandState state, std::string reason);
  /// Ends a command whose device or point is removed: there is no status to publish.
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
  KeptOutcomes outcomes_;
  base::OncePerTurn next_turn_;
  Queue accepted_;                                          ///< in this turn, started in the next
  std::unordered_map<DeviceNumber, Queue> queues_;          ///< live commands, oldest first
  std::unordered_map<std::uint64_t, Command*> by_request_;  ///< the live ones, by Command::request
  std::size_t live_ = 0;
};

}  // namespace rubicon::proxy
