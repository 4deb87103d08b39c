#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/message.h"
#include "rubicon/tuple_space.hpp"
#include "tuples/judge.h"

namespace rubicon::gateway {

/// The member that a message names as its sender, as judges ask for it. `through`: who handed it on, and says so.
tuples::Member member_of(const model::Sender& sender, const std::string& through = {});
/// How a message names a member.
model::Sender sender_of(const tuples::Member& member);

/// The host that the component which posted a message declares; empty = none, or another handed the message on. Valid
/// during the call.
std::string_view host_of(TupleSpace& space, const Message& message);
/// Whether a component may speak as an island: the one whose certificate has its id, or, on an engine that knows no
/// members, each with such an id.
bool is_true_island(TupleSpace& space, OwnerId component);

/// The island that handed a message on and named its sender, by its own certificate; nullopt: its sender came itself.
using Relay = std::optional<model::Sender>;

/// The names of where a message goes, as rights name it: of a device `<network>.<address>` and, if that differs, the
/// one in the keys of its tuples. The first one is shown.
using Places = std::vector<std::string>;

/// Judges the messages of other components by the rights of who sent them first (docs/rights.md). Without a judge, and
/// for components of this process, everything is allowed.
class MessageRights {
 public:
  explicit MessageRights(TupleSpace& space) : space_(space) {}

  /// Puts the sender into a message that a component posted, or believes what it says where a certified island relays
  /// it. kRefused: it was relayed by a component for which its wire does not vouch as an island.
  Result<Relay> name_sender(OwnerId from, Message& message) const;
  /// Whether its sender may send it there: `island:N`, `<network>.<device>`, `own`; and may_relay(). A refusal leaves a
  /// line in the audit; of what is permitted record() writes it. A sender with more roles than a message may name sends
  /// nothing to other islands: a role that is left out might be one that a rule denies something.
  Result<void> may_send(const Message& message, const Relay& relay, const Places& where) const;
  /// The same as a question: it leaves no line in the audit, and a refusal is not counted.
  Result<void> ask(const Message& message, const Relay& relay, const Places& where) const;
  /// may_relay() as a question.
  bool is_believed(const Relay& relay, const Places& where) const;
  /// Whether the island that handed it on may send there itself: only then it is believed about its sender. A refusal
  /// leaves a line in the audit.
  Result<void> may_relay(const Message& message, const Relay& relay, const Places& where) const;
  /// The line of a message of another component that was delivered there, or could not be.
  void record(const Message& message, const Relay& relay, std::string_view where, const Result<void>& answer) const;

 private:
  TupleSpace& space_;
};

/// The answer to a command for anything that its sender may not know of, whether it exists or not.
Error may_not_set(const Message& message);

/// Where messages go that name no network.
inline constexpr std::string_view kOwn = "own";
/// Where a message for this island goes, as rights name it: `wsn-1.7`, the network alone, or `own`.
std::string place_of(const Address& to);

}  // namespace rubicon::gateway
