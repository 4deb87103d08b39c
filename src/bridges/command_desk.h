#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <string>
#include <string_view>

#include "bridges/bridge.h"
#include "bridges/house.h"
#include "bridges/scope.h"
#include "client/remote_set_tracker.h"

namespace rubicon::bridges {

/// Commands of those at the other side of a bridge: asks whether the bridge may, sets the tuple as the member
/// `bridge:<name>`, and follows what becomes of it.
class CommandDesk {
 public:
  static constexpr std::size_t kMaxUnderWay = 1000;
  static constexpr std::size_t kMaxText = std::size_t{64} << 10U;  ///< of a command, in bytes
  static constexpr Duration kTimeToLive = std::chrono::seconds(5);

  CommandDesk(const BridgeHost& host, const Scope& scope) : host_(host), scope_(scope) {}

  /// kOutOfRange, kBusy, or kRefused, which is in the audit. `sender`: for the audit, may be empty.
  Result<void> check(const PointEntry& point, std::string_view value, std::string_view sender) const;
  /// What check() accepted. `ended` is called once, unless the desk is destroyed before.
  void send(const PointEntry& point, std::string_view value, std::string_view sender, Duration lives,
            client::OutcomeCall ended);

 private:
  Result<void> may(const tuples::RemoteSet& set, std::string_view sender) const;

  struct Running {
    std::unique_ptr<client::RemoteSetTracker> tracker;
    Handle spoken_for;
  };
  const BridgeHost& host_;
  const Scope& scope_;
  std::list<Running> under_way_;
};

}  // namespace rubicon::bridges
