#include "networks/zigbee/definition_gaps.h"

#include <fmt/format.h>

#include <utility>

#include "networks/zigbee/exposes/mapping.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::zigbee {

void DefinitionGaps::put(const bridge::DeviceRecord& record) {
  Gaps gaps{record.skipped, exposes::unknown_units(record.leaves)};
  const auto known = gaps_.find(record.address);
  if (known == gaps_.end() ? gaps.empty() : known->second == gaps) return;
  remove(record.address);
  if (gaps.empty()) return;
  skipped_ += gaps.skipped.size();
  unknown_units_ += gaps.units.size();
  name(record, gaps);
  gaps_.emplace(record.address, std::move(gaps));
}

void DefinitionGaps::remove(const std::string& address) {
  const auto known = gaps_.find(address);
  if (known == gaps_.end()) return;
  skipped_ -= known->second.skipped.size();
  unknown_units_ -= known->second.units.size();
  gaps_.erase(known);
}

void DefinitionGaps::name(const bridge::DeviceRecord& record, const Gaps& gaps) {
  const auto first = gaps.skipped.empty() ? fmt::format("the unit {} is unknown", model::quoted(gaps.units.front()))
                                          : "left out: " + gaps.skipped.front();
  const auto others = gaps.skipped.size() + gaps.units.size() - 1;
  log_.warning("definition " + record.address,
               fmt::format("{}: {}{}", model::quoted(record.name), first,
                           others == 0 ? "" : fmt::format(", and {} more of its definition", others)));
}

}  // namespace rubicon::networks::zigbee
