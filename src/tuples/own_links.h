#pragma once

#include <map>
#include <vector>

#include "base/scheduler.h"
#include "rubicon/address.hpp"

namespace rubicon::tuples {

/// The links of this process to one engine, by component. It does not own them.
template <class Link>
class OwnLinks {
 public:
  void put(OwnerId id, Link& link) { links_[id] = &link; }
  void erase(OwnerId id) { links_.erase(id); }
  /// nullptr: this process has no such component.
  Link* find(OwnerId id) const {
    const auto found = links_.find(id);
    return found == links_.end() ? nullptr : found->second;
  }
  const std::map<OwnerId, Link*>& all() const { return links_; }
  /// Calls those that are attached. A call may end links, and this.
  template <class Call>
  void each(Call call) const {
    std::vector<OwnerId> ids;
    for (const auto& [id, link] : links_) ids.push_back(id);
    const auto alive = lifetime_.watch();
    for (const auto id : ids) {
      auto* link = alive.ended() ? nullptr : find(id);
      if (link && link->attached()) call(*link);
    }
  }

 private:
  std::map<OwnerId, Link*> links_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::tuples
