#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/virtual_scheduler.h"
#include "support/collecting_log.h"
#include "support/memory/memory_transports.h"
#include "tuples/cuttable_link.h"
#include "tuples/peis/peis_ecology.h"

namespace rubicon::tuples::peis {

/// Components that meet over PEIS in virtual time on one machine: each is configured to connect to those before it.
class PeisTestEcology {
 public:
  /// Bytes need no time, as the suite runs what is due without waiting.
  explicit PeisTestEcology(VirtualScheduler& time) : time_(time), net_(time) {
    net_.tcp.transit = net_.lookup_time = Duration(0);
    machine_.join(net_);
  }

  Result<std::unique_ptr<Link>> join(OwnerId id) {
    PeisOptions options;
    options.multicast = false;
    for (std::size_t i = 0; i < ecologies_.size(); ++i)
      options.connect.push_back("127.0.0.1:" + std::to_string(kFirstListenPort + i));
    auto opened = PeisEcology::open(options, time_, machine_, log_, here());
    if (!opened) return fail(opened.error());
    ecologies_.push_back(std::move(*opened));
    auto link = ecologies_.back()->join(id);
    if (!link) return fail(link.error());
    return std::make_unique<CuttableLink>(std::move(*link), links_, id);
  }

  void cut(OwnerId a, OwnerId b) {
    each(a, b, [](CuttableLink& link, OwnerId peer) { link.cut(peer); });
  }
  void mend(OwnerId a, OwnerId b) {
    each(a, b, [](CuttableLink& link, OwnerId peer) { link.mend(peer); });
  }

 private:
  /// Each component in a process of its own.
  PeisMachine here() const {
    return {
        {{"lo", "127.0.0.1", true, true, true}}, "hostx", "host-of-hostx", std::to_string(ecologies_.size()), "anna"};
  }

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
  transport::MemoryNet net_;
  transport::MemoryTransports machine_;
  support::CollectingLog log_;
  std::map<OwnerId, CuttableLink*> links_;
  std::vector<std::unique_ptr<PeisEcology>> ecologies_;
};

}  // namespace rubicon::tuples::peis
