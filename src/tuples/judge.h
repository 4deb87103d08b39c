#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "rubicon/tuple.hpp"
#include "rubicon/tuple_space.hpp"
#include "tuples/member.h"

namespace rubicon::tuples {

/// What a subscription of a member gets of one tuple.
struct Access {
  bool read = true;
  bool demand = true;    ///< false: the subscription counts as passive for this tuple
  Duration interval{0};  ///< fastest demand; 0 = any
  friend bool operator==(const Access&, const Access&) = default;
};

/// What a member asked for by other means than a remote set: a message, or a request to the web server.
struct Wish {
  OwnerId component{};    ///< that asked; kNoOwner = none
  std::string_view host;  ///< of the component, as it declares it; of a request its IP address; empty = not known
  std::string_view verb;  ///< set, append, send, read, demand
  std::string_view key;   ///< of a message where it goes, as may_send() has it
  std::string_view value;
};

/// What is asked for under several names.
enum class Act : std::uint8_t { kSet, kSend };

/// Decides what members may do: the rights of an owner (docs/rights.md). The policy of a link, the gateway and the web
/// server ask the same judge. The members it is asked about are authenticated; it never sees ids alone.
class Judge {
 public:
  virtual ~Judge() = default;
  /// Asked once for each tuple that a subscription joins, never per publication. Must be fast.
  virtual Access access(const Member& who, std::string_view key) const = 0;
  /// Whether access() gives the member all tuples with all demand: then nothing is asked per tuple.
  virtual bool sees_all(const Member& who) const = 0;
  /// Whether the member may ask for this set or append: right `set`, for the inbox `approve`. The error is for the
  /// reply.
  virtual Result<void> may_set(const Member& who, const RemoteSet& set) const = 0;
  /// Whether the member may send messages there: `<network>.<device>`, `island:<id>`, or `own` for this island itself.
  virtual Result<void> may_send(const Member& who, std::string_view where) const = 0;
  /// The same of what has several names, at least one: what is denied by one of them is denied, else what is allowed by
  /// one is allowed.
  virtual Result<void> may_by_names(const Member& who, Act act, std::span<const std::string> names) const = 0;
  /// The same as a question: judges that count what they refuse do not count it.
  virtual Result<void> ask(const Member& who, Act act, std::span<const std::string> names) const {
    return may_by_names(who, act, names);
  }
  /// Whether a member is believed what it asks for in the name of another one, such as `user:ann` (docs/rights.md).
  virtual bool may_vouch(const Member&, std::string_view) const { return false; }
  /// The remote set with this number of a component of this process is the wish of that member, as long as the handle
  /// lives.
  [[nodiscard]] virtual Handle speak_for(const Member& who, OwnerId component, std::uint64_t request) = 0;
  /// Who is behind a remote set of a component of this process; nullptr: the process itself. Valid during the call.
  virtual const Member* spoken_for(OwnerId component, std::uint64_t request) const = 0;
  /// A wish of a component of another process was answered, whoever refused it: one line for the audit. `host`:
  /// of the component, as it declares it.
  /// Messages arrive as sets of GATEWAY: what the gateway takes it reports by record(); only refusals are lines here.
  virtual void answered(const Member& who, std::string_view host, const RemoteSet& set, const Reply& reply) = 0;
  /// The same for a wish that was no remote set.
  virtual void record(const Member& who, const Wish& wish, const Result<void>& answer) = 0;
};

}  // namespace rubicon::tuples
