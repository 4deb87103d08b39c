#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "proxy/command_desk.h"
#include "proxy/demand.h"
#include "proxy/discovery_inbox.h"
#include "proxy/hand_over.h"
#include "proxy/liveness.h"
#include "proxy/memory.h"
#include "proxy/network_board.h"
#include "proxy/proxy.h"
#include "proxy/roaming.h"

namespace rubicon::proxy {

using tuples::Handle;

/// The parts and the wires between them: messages come in here, each part is told in the order of the life of a
/// reading; no part calls back.
struct Proxy::Impl {
  Impl(ProxyConfig rules, Scheduler& scheduler, TupleSpace& space, gateway::Gateway& gateway,
       const TypeCatalogue& types, base::LogSink& log, state::StateStore* store);

  void listen();
  template <class Body>
  void on(MessageKind kind, void (Impl::*call)(Device*, Network&, const Message&, const Body&));

  void join(Device*, Network& network, const Message& message, const model::Join& join);
  void keep_alive(Device* device, Network& network, const Message& message, const model::KeepAlive&);
  void leave(Device* device, Network& network, const Message& message, const model::Leave& leave);
  void updates(Device* device, Network& network, const Message& message, const model::Updates& updates);
  void state(Device* device, Network& network, const Message& message, const model::State& state);
  void acknowledge(const Message& message);

  void heard(Device& device);
  void reachable(Device& device, bool was_lost);
  void lost(Device& device);
  void probe(const Device& device);
  void reading(Device& device, const model::Reading& reading);
  void presume_line(Network& network);
  void set_line(Network& network, const model::State& state);
  void line_went_down(Network& network);
  void line_came_up(Network& network);
  Device* stranger(Network& network, const Message& message);
  void take_rate(Device& device);
  void warn_of_lost_names(const Device& device);

  // proxy_discovery.cpp: which devices are let in, and what is remembered of them
  bool let_in(Network& network, const DeviceName& name, const Announced& announced, const state::KnownDevice* known,
              bool listed);
  bool admit(Network& network, const std::string& address, const Announced& announced, const state::KnownDevice* known);
  /// admit(), unless another island lists the device.
  bool enter(Network& network, const std::string& address, const Announced& announced, const state::KnownDevice* known,
             bool approved = false);
  Device* try_again(Network& network, const DeviceName& name, bool approved = false);
  void park(const DeviceName& name, const Announced& announced, const std::string& why);
  void bring_back(Device& device, const state::KnownDevice& known);
  void restore(const std::string& network);
  void restore(Network& network, Memory::Row row, state::KnownDevice&& known);
  Device* device_with_key(std::string_view parts);
  tuples::SetDecision judge_inbox(const tuples::RemoteSet& wish);
  void carry_out();
  void approve(const DeviceName& name);
  void ignore(const DeviceName& name);
  void remove(Device& device);

  // proxy_names.cpp: what users call devices
  tuples::SetDecision judge_description(const tuples::RemoteSet& wish);
  Result<void> give_name(Device& device, std::string name, std::string area, OwnerId by);

  // proxy_roaming.cpp: devices that go to other islands and come from them
  void moved(Device& device, const Claim& to, const std::string& tuple);
  Device* arrive(const DeviceName& name);
  bool elsewhere(Network& network, const std::string& address, Device*& device);
  void change_domain(Network& network, const std::string& domain);

  // proxy_changes.cpp: new rules while running
  std::vector<std::string> objections(const ProxyConfig& next) const;
  std::vector<std::string> lost_names_in(const std::string& network, const NetworkRules& next) const;
  void reconfigure(ProxyConfig next);
  void restart(const std::string& id);
  void drop_network(const std::string& id);
  void drop_devices(Network& network);
  void change_rules(Network& network, NetworkRules rules);
  void free_reserved_keys(Network& network);
  void rename(Network& network, NetworkRules rules, const std::vector<Device*>& renamed);
  void set_rate(Device& device, std::chrono::milliseconds rate);
  void ask_again();

  ProxyConfig config;
  ProxyContext context;
  DeviceDirectory directory;
  Memory memory;
  DiscoveryInbox inbox;
  NetworkBoard board;
  TupleMirror mirror;
  Liveness liveness;
  Demand demand;
  CommandDesk desk;
  Roaming roaming;
  HandOver hand_over;
  std::vector<std::pair<DeviceName, state::Decision>> decisions;  ///< judged in this turn
  base::OncePerTurn decisions_turn;
  std::vector<Handle> handles;
};

}  // namespace rubicon::proxy
