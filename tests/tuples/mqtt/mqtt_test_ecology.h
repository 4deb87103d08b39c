#pragma once

#include <map>
#include <memory>
#include <vector>

#include "base/virtual_scheduler.h"
#include "support/collecting_log.h"
#include "support/memory/memory_transports.h"
#include "support/memory/mqtt_broker.h"
#include "tuples/cuttable_link.h"
#include "tuples/mqtt/mqtt_ecology.h"

namespace rubicon::tuples::mqtt {

/// Components in virtual time that meet at a broker in memory, each in a process of its own.
class MqttTestEcology {
 public:
  explicit MqttTestEcology(VirtualScheduler& time) : time_(time), net_(time), broker_(net_, kAt) {
    net_.lookup_time = {};
    broker_.latency = {};
    broker_.keeps_published = false;
    transports_.join(net_, "10.0.0.2");
  }

  Result<std::unique_ptr<Link>> join(OwnerId id) {
    SpaceOptions options;
    options.brokers.emplace_back().line.host = kAt.address;
    options.brokers.back().line.port = kAt.port;
    options.trust_broker = true;
    options.watch_all = true;
    auto opened =
        MqttEcology::open(options, time_, transports_, log_, [this] { return time_.now().time_since_epoch(); });
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
  static inline const transport::Endpoint kAt{"10.0.0.1", 1883};

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
  transport::MemoryNet net_;
  transport::MqttBroker broker_;
  transport::MemoryTransports transports_;
  std::map<OwnerId, CuttableLink*> links_;
  std::vector<std::unique_ptr<MqttEcology>> ecologies_;
};

}  // namespace rubicon::tuples::mqtt
