#pragma once

#include <map>
#include <memory>
#include <vector>

#include "base/virtual_scheduler.h"
#include "support/collecting_log.h"
#include "support/memory/memory_folder.h"
#include "tuples/cuttable_link.h"
#include "tuples/host/host_ecology.h"

namespace rubicon::tuples::host {

/// Components that meet in a folder in memory and virtual time, each in a process of its own.
class HostTestEcology {
 public:
  explicit HostTestEcology(VirtualScheduler& time) : time_(time), host_(time) {}

  Result<std::unique_ptr<Link>> join(OwnerId id) {
    auto opened = HostEcology::open(host_.enter(), {}, time_, log_);
    if (!opened) return fail(opened.error());
    auto link = (*opened)->join(id);
    if (!link) return fail(link.error());
    ecologies_.push_back(std::move(*opened));
    return std::make_unique<CuttableLink>(std::move(*link), links_, id);
  }

  void cut(OwnerId a, OwnerId b) {
    each(a, b, [](CuttableLink& link, OwnerId peer) { link.cut(peer); });
  }
  void mend(OwnerId a, OwnerId b) {
    each(a, b, [](CuttableLink& link, OwnerId peer) { link.mend(peer); });
  }

 private:
  /// In a later turn, as everything that links report.
  template <class Call>
  void each(OwnerId a, OwnerId b, Call call) {
    time_.post([this, a, b, call] {
      for (const auto& [one, other] : {std::pair(a, b), std::pair(b, a)}) {
        if (const auto found = links_.find(one); found != links_.end()) call(*found->second, other);
      }
    });
  }

  VirtualScheduler& time_;
  support::CollectingLog log_;
  MemoryHost host_;
  std::map<OwnerId, CuttableLink*> links_;
  std::vector<std::unique_ptr<HostEcology>> ecologies_;
};

}  // namespace rubicon::tuples::host
