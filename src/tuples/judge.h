#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/address.hpp"
#include "rubicon/time.hpp"
#include "rubicon/tuple.hpp"
#include "rubicon/tuple_space.hpp"

namespace rubicon::tuples {

/// A range of component ids, both ends included.
struct IdRange {
  std::uint32_t first = 0, last = 0;

  bool contains(OwnerId id) const { return first <= number(id) && number(id) <= last; }
  friend bool operator==(const IdRange&, const IdRange&) = default;
};

/// The names of all components of engines PEIS and DDS, which never know who asks.
inline constexpr std::string_view kPeisMember = "peis", kLanMember = "lan";

/// Who a component is, as its engine knows it: on host by the kernel, on mqtt by the broker and the realm. DDS and PEIS
/// know nothing: there it is always `lan` or `peis`.
struct Member {
  std::string name;
  std::vector<std::string> roles{};
  std::vector<IdRange> ids{};  ///< ids that its components may use; an unknown member may use any
  std::string through{};       ///< the member that handed its message on and says who it is; empty = it was here itself

  /// Whether it is only the wire by which it came. `peis@hall`: by a carrier.
  bool is_unproven() const {
    const auto wire = std::string_view(name).substr(0, name.find('@'));
    return wire == kPeisMember || wire == kLanMember;
  }
  /// Its name with its source, as a component gives it that passes a request on for it.
  std::string name_with_source() const {
    return name.find(':') != name.npos || name == kPeisMember || name == kLanMember ? name : "member:" + name;
  }
  bool may_use(OwnerId id) const {
    return std::any_of(ids.begin(), ids.end(), [id](const IdRange& one) { return one.contains(id); });
  }
  bool has_role(std::string_view role) const { return std::find(roles.begin(), roles.end(), role) != roles.end(); }
  friend bool operator==(const Member&, const Member&) = default;
};

/// What a member's subscription receives from one tuple.
struct Access {
  bool read = true;
  bool demand = true;    ///< false: the subscription counts as passive for this tuple
  Duration interval{0};  ///< fastest demand; 0 = any
  friend bool operator==(const Access&, const Access&) = default;
};

/// What a member asked for by other means than a remote set: a message, or a request to the web server.
struct OtherRequest {
  OwnerId component{};    ///< that asked; kNoOwner = none
  std::string_view host;  ///< of the component, as it declares it; of a request its IP address; empty = not known
  std::string_view verb;  ///< set, append, send, read, demand
  std::string_view key;   ///< of a message its receiver, as may_send() names it
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
  /// What may_by_names() would say. Judges that count their refusals do not count this one.
  virtual Result<void> would_allow(const Member& who, Act act, std::span<const std::string> names) const {
    return may_by_names(who, act, names);
  }
  /// Whether a member is believed what it asks for in the name of another one, such as `user:ann` (docs/rights.md).
  virtual bool may_vouch(const Member&, std::string_view) const { return false; }
  /// While the handle lives, the remote set with this number, from a component of this process, is a request of that
  /// member.
  [[nodiscard]] virtual Handle speak_for(const Member& who, OwnerId component, std::uint64_t request) = 0;
  /// The member for which a component of this process sends a remote set; nullptr: the process itself. Valid during the
  /// call.
  virtual const Member* spoken_for(OwnerId component, std::uint64_t request) const = 0;
  /// A request of a component of another process was answered or refused: writes one line of the audit. `host`: of the
  /// component, as it declares it. Messages arrive as sets of GATEWAY: what the gateway takes it reports by record();
  /// only refusals are lines here.
  virtual void answered(const Member& who, std::string_view host, const RemoteSet& set, const Reply& reply) = 0;
  /// The same for a request that was no remote set.
  virtual void record(const Member& who, const OtherRequest& request, const Result<void>& answer) = 0;
};

/// The users of a broker, from a signed document that members pass on to each other. Any member may bring the newest
/// one, because its signature proves it. Implemented by `trust`; outlives the ecology.
class UserRealm {
 public:
  static constexpr std::size_t kMaxDocument = 256UL * 1024;  ///< bytes
  enum class Taken : std::uint8_t { kNewer, kOlder, kWrong };

  virtual ~UserRealm() = default;
  /// nullptr: no such member, or it was shut out. Fast. Equal pointers as long as nothing changes for that user.
  virtual std::shared_ptr<const Member> member(std::string_view user) const = 0;
  /// The newest one, at most kMaxDocument bytes.
  virtual const std::string& document() const = 0;
  /// Takes a document that `from` brought. kNewer: it counts from now on, and the functions given to watch() were
  /// called.
  virtual Taken take(std::string_view document, std::string_view from) = 0;
  /// `call` runs after each change, also if the newer one was found on the disk. Calls are made in the order in which
  /// they were asked for.
  [[nodiscard]] virtual Handle watch(std::function<void()> call) = 0;
};

}  // namespace rubicon::tuples
