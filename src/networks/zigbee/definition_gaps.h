#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "base/limited_log.h"
#include "networks/zigbee/bridge/device_record.h"

namespace rubicon::networks::zigbee {

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
