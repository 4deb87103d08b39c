#pragma once

#include <string>
#include <string_view>

#include "base/scheduler.h"
#include "proxy/admission/roaming.h"
#include "proxy/command_desk.h"

namespace rubicon::proxy::admission {

/// Transfers commands that are not sent yet, and the `rate` that a user set, to the island (or network) that a device
/// moved to, as remote sets of the claim tuple there, and accepts those that others transfer (docs/roaming.md). A
/// command leaves the queue before it is transferred, so it is never executed twice; it keeps the creator and request
/// of its commander.
class CommandTransfer {
 public:
  CommandTransfer(ProxyContext& context, DeviceDirectory& directory, CommandDesk& desk, Roaming& roaming)
      : context_(context), directory_(directory), desk_(desk), roaming_(roaming) {}

  /// `tuple` is the key of the other claim. A command that the other island refuses is published as failed in the
  /// `.status` of its point here, for ten seconds.
  void send(Device& device, const Claim& to, const std::string& tuple);
  /// A remote set of one of our claims: a command transferred from another island.
  tuples::SetDecision decide_set(const tuples::RemoteSet& request);
  /// The device is listed again: erases the statuses of failed transfers, which have the keys of its own tuples.
  void clear(const Device& device);

 private:
  void send_rate(Device& device, const Claim& to, const std::string& tuple);
  Result<void> may_hand_over(const tuples::RemoteSet& request, const std::string& command) const;
  void answered(Command& command, const std::string& status, OwnerId island, const tuples::Reply& reply);

  ProxyContext& context_;
  DeviceDirectory& directory_;
  CommandDesk& desk_;
  Roaming& roaming_;
  base::Lifetime lifetime_;
};

/// A command in transfer to another island: {kind, type, instance, value, creator, request}.
struct WaitingCommand {
  PointId point;
  std::string value;
  OwnerId creator{};
  std::uint64_t request = 0;

  friend bool operator==(const WaitingCommand&, const WaitingCommand&) = default;
};
std::string waiting_command_text(const WaitingCommand& command);
/// kInvalid: a member is missing or wrong.
Result<WaitingCommand> parse_waiting_command(std::string_view text);

}  // namespace rubicon::proxy::admission
