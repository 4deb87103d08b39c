#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "support/memory/memory_folder.h"
#include "support/memory/memory_transports.h"
#include "support/memory/mqtt_broker.h"
#include "tuples/carry/carrying.h"
#include "tuples/host/host_ecology.h"
#include "tuples/mqtt/mqtt_ecology.h"
#include "tuples/peis/peis_ecology.h"

namespace rubicon::tuples::carry {

/// The engine of a process, and how it is killed: without a goodbye, before the engine ends.
struct Entered {
  std::unique_ptr<StandInEcology> engine;
  std::function<void()> kill = [] {};
};

/// What components of several processes meet on, in virtual time. Outlives the engines.
class Wire {
 public:
  virtual ~Wire() = default;
  virtual Entered enter() = 0;
};

/// DDS as components see it: all of them meet at once, and one that comes displaces its stand-in.
class TwinWire final : public Wire {
 public:
  explicit TwinWire(VirtualScheduler& time) : time_(time), memory_(time, "host-of-all") {}
  Entered enter() override { return {std::make_unique<Process>(*this)}; }

 private:
  class Process final : public StandInEcology {
   public:
    explicit Process(TwinWire& wire) : wire_(wire) {}
    Result<std::unique_ptr<Link>> join(OwnerId id) override {
      auto link = wire_.memory_.join(id);
      if (link) return link;
      wire_.displaced_.at(id)();
      wire_.time_.run_ready();
      return wire_.memory_.join(id);
    }
    Result<std::unique_ptr<Link>> join_as(StandIn who) override {
      auto link = wire_.memory_.join_as(who);
      if (link) wire_.displaced_[who.id] = who.displaced;
      return link;
    }

   private:
    TwinWire& wire_;
  };

  VirtualScheduler& time_;
  MemoryEcology memory_;
  std::map<OwnerId, std::function<void()>> displaced_;
};

class HostWire final : public Wire {
 public:
  HostWire(VirtualScheduler& time, base::LogSink& log) : time_(time), log_(log), host_(time) {}
  Entered enter() override {
    auto engine = std::move(*host::HostEcology::open(host_.enter(), {}, time_, log_));
    return {std::move(engine), [this, process = ++last_] { host_.kill(process); }};
  }

 private:
  VirtualScheduler& time_;
  base::LogSink& log_;
  host::MemoryHost host_;
  pid_t last_ = 0;
};

class BrokerWire final : public Wire {
 public:
  BrokerWire(VirtualScheduler& time, base::LogSink& log) : time_(time), log_(log), net_(time), broker_(net_, kAt) {
    broker_.keeps_published = false;
    machine_.join(net_, "10.0.0.2");
  }
  Entered enter() override { return enter("anna"); }
  /// `realm`: as SpaceOptions::realm.
  Entered enter(const std::string& user, std::shared_ptr<UserRealm> realm = nullptr) {
    mqtt::SpaceOptions options;
    auto& at = options.brokers.emplace_back();
    at.user = user;
    at.line.host = kAt.address;
    at.line.port = kAt.port;
    at.line.client_id = "process" + std::to_string(++last_);
    options.watch_all = true;
    options.realm = std::move(realm);
    options.trust_broker = true;
    const auto since_boot = [this] { return time_.now().time_since_epoch(); };
    return {std::move(*mqtt::MqttEcology::open(options, time_, machine_, log_, since_boot)),
            [this, client = at.line.client_id] { broker_.stall(client, true); }};
  }

 private:
  static inline const transport::Endpoint kAt{"10.0.0.1", 1883};

  VirtualScheduler& time_;
  base::LogSink& log_;
  transport::MemoryNet net_;
  transport::MqttBroker broker_;
  transport::MemoryTransports machine_;
  int last_ = 0;
};

/// Each connects to those before it.
class PeisWire final : public Wire {
 public:
  PeisWire(VirtualScheduler& time, base::LogSink& log) : time_(time), log_(log), net_(time) { machine_.join(net_); }
  Entered enter() override {
    peis::PeisOptions options;
    options.multicast = false;
    for (int i = 0; i < last_; ++i)
      options.connect.push_back("127.0.0.1:" + std::to_string(peis::kFirstListenPort + i));
    const peis::PeisMachine machine{
        {{"lo", "127.0.0.1", true, true, true}}, "hostx", "host-of-all", std::to_string(++last_), "anna"};
    return {std::move(*peis::PeisEcology::open(options, time_, machine_, log_, machine))};
  }

 private:
  VirtualScheduler& time_;
  base::LogSink& log_;
  transport::MemoryNet net_;
  transport::MemoryTransports machine_;
  int last_ = 0;
};

inline std::unique_ptr<Wire> make_wire(const std::string& name, VirtualScheduler& time, base::LogSink& log) {
  if (name == "host") return std::make_unique<HostWire>(time, log);
  if (name == "mqtt") return std::make_unique<BrokerWire>(time, log);
  if (name == "peis") return std::make_unique<PeisWire>(time, log);
  return std::make_unique<TwinWire>(time);
}

/// A process with one component, on one or several wires, by the names of their engines.
template <class Member = Observer>
class Site {
 public:
  using On = std::vector<std::pair<std::string, Wire*>>;
  Site(VirtualScheduler& time, base::LogSink& log, std::uint32_t id, const On& wires, const CarryRules& rules = {}) {
    std::vector<Carrier::Engine> open;
    for (const auto& [name, wire] : wires) {
      entered_.push_back(wire->enter());
      open.push_back({name, *entered_.back().engine});
    }
    if (!rules.empty()) carrier_ = std::make_unique<Carrier>(OwnerId(id), rules, open, time, log);
    std::vector<joined::JoinedEcology::Engine> all;
    for (std::size_t i = 0; i < open.size(); ++i)
      all.push_back({open[i].name, carrier_ ? carrier_->engine(i) : open[i].ecology});
    joined_ = std::make_unique<joined::JoinedEcology>(all, time, log);
    self_ = std::make_unique<Member>(*joined_, time, id);
  }
  Member* operator->() const { return self_.get(); }
  std::size_t stand_ins() const { return carrier_->stand_ins(); }
  /// Call it before the end of the site.
  void kill() const {
    for (const auto& one : entered_) one.kill();
  }

 private:
  std::vector<Entered> entered_;
  std::unique_ptr<Carrier> carrier_;
  std::unique_ptr<joined::JoinedEcology> joined_;
  std::unique_ptr<Member> self_;
};

}  // namespace rubicon::tuples::carry
