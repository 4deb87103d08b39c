#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "tuples/link.h"

namespace rubicon::tuples {

/// A component on an engine in place of one that is on another engine only (docs/decisions/022-two-engines.md).
struct StandIn {
  OwnerId id{};      ///< of the component
  std::string host;  ///< PeerIdentity::host to show: marked_host()
  /// Called in a later turn: another presence uses the id on this engine. The stand-in should end.
  std::function<void()> displaced;
};

/// An engine that stand-ins can join.
class StandInEcology : public Ecology {
 public:
  /// As join().
  virtual Result<std::unique_ptr<Link>> join_as(StandIn who) = 0;
  /// False: whoever has that component, others here believe no stand-in of its for that id.
  virtual bool may_stand_in(OwnerId /*carrier*/, OwnerId /*id*/) const { return true; }
};

/// The host of a component, as its stand-in shows it: `<host>~<id of the carrier>`, at most 64 bytes.
std::string marked_host(std::string_view host, OwnerId carrier);
/// kNoOwner: the host has no mark, so its component is no stand-in.
OwnerId carrier_of(std::string_view host);
inline bool is_stand_in(const PeerIdentity& peer) {
  return carrier_of(peer.host) != model::kNoOwner;
}
/// The host without a mark.
std::string_view real_host(std::string_view host);

}  // namespace rubicon::tuples
