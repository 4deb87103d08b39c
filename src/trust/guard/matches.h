#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "trust/guard/peers.h"

namespace rubicon::trust::guard {

enum class Kind : std::uint8_t { Writer, Reader };

/// How an endpoint says that it is protected: the two words of PID_ENDPOINT_SECURITY_INFO (DDS Security 1.1, 7.4.1.5).
struct Masks {
  std::uint32_t attributes = 0, plugin = 0;
};

/// What access control said yes to: an endpoint of another participant.
struct Approval {
  Kind kind = Kind::Writer;
  Handle permissions = 0;
  const void* endpoint = nullptr;  ///< the address of Cyclone's own text of its topic: one for each remote endpoint
  Masks masks;
  std::string topic;
  std::vector<std::string> partitions;
};

/// Lets an endpoint of this process and a remote one exchange keys only if access control was asked about that remote
/// one and said yes. Cyclone does not ask when the remote endpoint announces itself without the valid bit, and
/// exchanges keys all the same.
///
/// Cyclone asks and then registers in one go, on one thread, but tells the registering function only which endpoint of
/// this process and which remote participant it is about. So an approval belongs to a thread, to the permissions handle
/// of one remote participant, to one remote endpoint, serves once, and every new question takes it back. Cyclone also
/// asks without registering afterwards: when the two are matched already, and when their masks differ. Such an approval
/// must not serve another endpoint of the same liar that comes next on this thread; therefore it counts only for an
/// endpoint of this process with the same topic, with partitions and masks that match, and that has no match with that
/// remote endpoint yet.
class Matches {
 public:
  /// Topic and partitions of the endpoint that this thread registers next.
  void prepare(std::string topic, std::vector<std::string> partitions);
  /// `builtin`: Cyclone's own, which are not asked about.
  void local_endpoint(Handle local, bool builtin, Masks masks);
  void participant(Handle permissions, Handle remote, Handle identity);
  void participant_gone(Handle remote);
  void permissions_gone(Handle permissions);

  /// Takes back what this thread has.
  static void ask();
  static void approve(Approval approval);
  /// Takes the approval of this thread. nullopt: the two may exchange keys; else why not.
  std::optional<std::string> refusal(Kind kind, Handle local, Handle remote);
  /// They got a handle for their keys.
  void matched(Handle match, Handle local);
  void endpoint_gone(Handle handle);

  /// The identity of a remote participant; 0 = unknown.
  Handle identity_of(Handle remote) const;

 private:
  struct Local {
    bool builtin = false;
    Masks masks;
    std::string topic;
    std::vector<std::string> partitions;
  };
  using Pair = std::pair<Handle, const void*>;  ///< endpoint of this process, remote endpoint

  mutable std::mutex mutex_;
  std::unordered_map<Handle, Local> locals_;
  std::unordered_map<Handle, Handle> participants_;  ///< permissions -> remote participant
  std::unordered_map<Handle, Handle> identities_;    ///< remote participant -> identity
  std::unordered_map<Handle, Pair> matches_;
  std::set<Pair> matched_;
};

/// Of this process.
Matches& matches();

/// As DDS: two sets of partitions match if a name of one equals a name of the other, or fits a pattern of it. An empty
/// set is the set of the empty name (DDS 1.4, 2.2.3.13).
bool partitions_match(const std::vector<std::string>& some, const std::vector<std::string>& others);

}  // namespace rubicon::trust::guard
