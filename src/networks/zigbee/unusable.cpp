#include "networks/zigbee/unusable.h"

#include <fmt/format.h>

#include <utility>

#include "networks/zigbee/exposes/mapping.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::zigbee {

TopicConflicts::TopicConflicts(Scheduler& scheduler, const bridge::Topics& topics, base::LimitedLog& log,
                               std::function<void()> changed)
    : topics_(topics),
      log_(log),
      changed_(std::move(changed)),
      check_doubtful_(scheduler, [this] { check_doubtful(); }) {}

void TopicConflicts::put(const std::string& address, const std::string& name) {
  // Only such a name can be the topic for commands to another device.
  if (name.find("/set") != name.npos || name.find("/get") != name.npos)
    doubtful_.insert(address);
  else
    doubtful_.erase(address);
  check(address);
  if (!doubtful_.empty()) check_doubtful_.request();
}

void TopicConflicts::remove(const std::string& address) {
  problems_.erase(address);
  doubtful_.erase(address);
  if (!doubtful_.empty()) check_doubtful_.request();
}

void TopicConflicts::check(const std::string& address) {
  auto why = topics_.conflict(address);
  if (why.empty()) {
    problems_.erase(address);
    return;
  }
  auto& problem = problems_[address];
  if (problem != why) log_.warning("name " + address, why);
  problem = std::move(why);
}

void TopicConflicts::check_doubtful() {
  for (const auto& address : doubtful_) check(address);
  changed_();
}

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
