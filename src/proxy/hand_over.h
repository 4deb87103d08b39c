#pragma once

#include <string>

#include "proxy/command_desk.h"
#include "proxy/roaming.h"

namespace rubicon::proxy {

/// Sends what waits in the command queue after a device that moved to another island (or network), as remote sets of
/// the claim tuple there, and takes what others send so (docs/roaming.md). A command is taken out of the queue before
/// it is sent on, so it is never executed twice; creator and request stay those of its commander.
class HandOver {
 public:
  HandOver(ProxyContext& context, DeviceDirectory& directory, CommandDesk& desk, Roaming& roaming)
      : context_(context), directory_(directory), desk_(desk), roaming_(roaming) {}

  /// `tuple` is the key of the claim. What the other island refuses stands as failed in the command's status tuple here
  /// for ten seconds, the device being gone.
  void send(Device& device, const Claim& to, const std::string& tuple);
  /// Somebody wishes to set one of our claims.
  tuples::SetDecision judge(const tuples::RemoteSet& wish);
  /// The device is listed: what was left of it must not stand in the way of its tuples.
  void clear(const Device& device);

 private:
  void answered(Command& command, const std::string& status, OwnerId island, const tuples::Reply& reply);

  ProxyContext& context_;
  DeviceDirectory& directory_;
  CommandDesk& desk_;
  Roaming& roaming_;
  base::Lifetime lifetime_;
};

/// A command on its way to another island: {kind, type, instance, value, creator, request}.
struct WaitingCommand {
  PointId point;
  std::string value;
  OwnerId creator{};
  std::uint64_t request = 0;

  friend bool operator==(const WaitingCommand&, const WaitingCommand&) = default;
};
std::string waiting_command_text(const WaitingCommand& command);
/// kInvalid says what is wrong.
Result<WaitingCommand> parse_waiting_command(std::string_view text);

}  // namespace rubicon::proxy
