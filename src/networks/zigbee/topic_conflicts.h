#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>

#include "base/lifetime.h"
#include "base/limited_log.h"
#include "networks/zigbee/bridge/topics.h"

namespace rubicon::networks::zigbee {

/// Devices whose friendly names have no topics of their own (bridge::Topics::conflict). Such a name may be fine until
/// another device comes, or is renamed; the order does not matter.
class TopicConflicts {
 public:
  /// `changed` is called in a turn of its own. Each conflict is logged once.
  TopicConflicts(Scheduler& scheduler, const bridge::Topics& topics, base::LimitedLog& log,
                 std::function<void()> changed);

  /// A new device, or a new name of one, which the topics have already.
  void put(const std::string& address, const std::string& name);
  /// The topics do not have the device any longer.
  void remove(const std::string& address);
  /// By address, one sentence each.
  const std::map<std::string, std::string>& problems() const { return problems_; }

 private:
  void check(const std::string& address);
  void check_doubtful();

  const bridge::Topics& topics_;
  base::LimitedLog& log_;
  std::function<void()> changed_;
  std::map<std::string, std::string> problems_;
  std::set<std::string> doubtful_;  ///< devices whose names may be topics for commands to others
  base::OncePerTurn check_doubtful_;
};

}  // namespace rubicon::networks::zigbee
