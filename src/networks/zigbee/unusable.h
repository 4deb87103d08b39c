#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "networks/zigbee/bridge/device_record.h"
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

/// What of the definitions of the present devices is not used: counted, and named once for each definition.
class DefinitionGaps {
 public:
  explicit DefinitionGaps(base::LimitedLog& log) : log_(log) {}

  /// A new device, or a new definition of one.
  void put(const bridge::DeviceRecord& record);
  void remove(const std::string& address);
  /// Parts of exposes that cannot be read.
  std::uint64_t skipped() const { return skipped_; }
  /// Leaves whose unit is in no table: they keep its spelling.
  std::uint64_t unknown_units() const { return unknown_units_; }

 private:
  struct Gaps {
    std::vector<std::string> skipped, units;
    bool empty() const { return skipped.empty() && units.empty(); }
    friend bool operator==(const Gaps&, const Gaps&) = default;
  };
  void name(const bridge::DeviceRecord& record, const Gaps& gaps);

  base::LimitedLog& log_;
  std::map<std::string, Gaps> gaps_;  ///< by address; devices without gaps are not there
  std::uint64_t skipped_ = 0, unknown_units_ = 0;
};

}  // namespace rubicon::networks::zigbee
