#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "proxy/admission/admission.h"
#include "proxy/admission/command_transfer.h"
#include "proxy/command_desk.h"
#include "proxy/demand.h"
#include "proxy/liveness.h"
#include "proxy/memory.h"
#include "proxy/network_tuples.h"
#include "proxy/proxy.h"
#include "proxy/tuple_mirror.h"

namespace rubicon::proxy {

/// Names and areas that users give to devices at run time.
class UserNames {
 public:
  UserNames(ProxyContext& context, DeviceDirectory& directory, Memory& memory, TupleMirror& mirror)
      : context_(context), directory_(directory), memory_(memory), mirror_(mirror) {}

  /// A remote set of `proxy.<network>.<device>.description`: JSON with `name`, `area` or both; other members belong to
  /// the device and are refused.
  tuples::SetDecision decide_set(const tuples::RemoteSet& request);

 private:
  Result<void> give(Device& device, std::string name, std::string area, OwnerId by);

  ProxyContext& context_;
  DeviceDirectory& directory_;
  Memory& memory_;
  TupleMirror& mirror_;
};

using admission::Admission;
using admission::Announced;
using admission::Claim;
using admission::CommandTransfer;
using admission::DeviceName;
using admission::last_announcement;
using tuples::Handle;

/// The parts and the calls between them. Messages arrive here and go to each part in the order of
/// docs/life-of-a-reading.md; parts call back only through the callbacks given to them here. Keeps the state of lines.
struct Proxy::Impl {
  Impl(ProxyConfig rules, Scheduler& scheduler, TupleSpace& space, gateway::Gateway& gateway,
       const TypeCatalogue& types, base::LogSink& log, state::StateStore* store);

  void listen();
  template <class Body>
  void on(MessageKind kind, void (Impl::*call)(Device*, Network&, const Message&, const Body&));

  void join(Device*, Network& network, const Message& message, const model::Join& join);
  void keep_alive(Device* device, Network& network, const Message& message, const model::KeepAlive&);
  void unreachable(Device* device, Network&, const Message&, const model::Unreachable& unreachable);
  void leave(Device* device, Network& network, const Message& message, const model::Leave& leave);
  void updates(Device* device, Network& network, const Message& message, const model::Updates& updates);
  void state(Device* device, Network& network, const Message& message, const model::State& state);
  void acknowledge(const Message& message);

  void fetch(std::span<const Message> next);

  void heard(Device& device);
  void reachable(Device& device, bool was_lost);
  void found_unreachable(Device& device, const std::string& reason, bool unusable);
  void usable_again(Device& device);
  void lost(Device& device);
  void probe(const Device& device);
  void reading(Device& device, const model::Reading& reading);
  void repeated(Device& device, const model::Reading& reading);
  void presume_line(Network& network);
  void set_line(Network& network, const model::State& state);
  void line_went_down(Network& network);
  void line_came_up(Network& network);
  void adopt_rate(Device& device);
  void warn_of_lost_names(const Device& device);

  // What follows from the decisions of the admission.
  void listed(const DeviceDirectory::Joined& joined, const Announced& announced, const state::KnownDevice* known);
  void restore_values(Device& device, const state::KnownDevice& known);
  void moved(Device& device, const Claim& to, const std::string& tuple);
  void ignored(Device& device);
  void remove(Device& device);

  // proxy_changes.cpp: new rules at run time
  void reconfigure(ProxyConfig next);
  void restart(const std::string& id);
  void drop_network(const std::string& id);
  void drop_devices(Network& network);
  void change_rules(Network& network, NetworkRules rules);
  void free_reserved_keys(Network& network);
  void rename(Network& network, NetworkRules rules, const std::vector<Device*>& renamed);
  void set_rate(Device& device, std::chrono::milliseconds rate);

  ProxyConfig config;
  ProxyContext context;
  DeviceDirectory directory;
  Memory memory;
  NetworkTuples network_tuples;
  TupleMirror mirror;
  UserNames user_names;
  Liveness liveness;
  Demand demand;
  CommandDesk desk;
  Admission admission;
  CommandTransfer transfer;
  std::vector<Handle> handles;
  struct Next {
    const Message* message;
    std::uint32_t hash;  ///< of its device
    Device* device;
  };
  std::vector<Next> next_readings;  ///< of fetch()
};

}  // namespace rubicon::proxy
