#include "networks/zigbee/topic_conflicts.h"

#include <utility>

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

}  // namespace rubicon::networks::zigbee
