#pragma once

#include <string>
#include <vector>

#include "networks/knx/wire/address.h"

namespace rubicon::networks::knx {

/// Which tunnels of a keyring were tried in vain. In each round all are tried but those whose user the interface
/// refused. Such a tunnel is skipped until the users of all are refused, or somebody reopens the line.
class TunnelRound {
 public:
  std::vector<wire::IndividualAddress> unusable() const;
  void in_use(wire::IndividualAddress tunnel) { taken_.push_back(tunnel); }
  void user_refused(wire::IndividualAddress tunnel) { users_refused_.push_back(tunnel); }

  /// All were tried; `why` names them. The line pauses now for the one that was tried last. True: another one should be
  /// tried at once, because the pause of a refused user is longer than that of tunnels in use.
  bool end(bool last_was_refused, const std::string& why);
  void up();
  void reopen() { users_refused_.clear(); }

  /// After a round without a free one: why; else empty.
  const std::string& text() const { return text_; }

 private:
  std::vector<wire::IndividualAddress> taken_;  ///< in this round
  std::vector<wire::IndividualAddress> users_refused_;
  std::string text_;
};

}  // namespace rubicon::networks::knx
