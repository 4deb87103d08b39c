#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "model/message.h"
#include "network/supervisor.h"
#include "rubicon/tuple_space.hpp"

namespace rubicon::gateway {

struct GatewayLimits {
  std::size_t queue = 10000;    ///< readings waiting per network (limits.queue)
  std::size_t devices = 20000;  ///< joins waiting per network: one a device (limits.devices)

  friend bool operator==(const GatewayLimits&, const GatewayLimits&) = default;
};

using MessageCall = std::function<void(const Message&)>;
using tuples::Handle;

/// Routes messages: own networks <-> local listeners <-> other islands through their GATEWAY tuple (D1.4,
/// Implementation). Delivers in a later turn, once and in order per source; every message that cannot be delivered is
/// answered with an Acknowledge{kUndeliverable | kBusy | ..., reason} to its source, unless it is an Acknowledge
/// itself.
class Gateway final : public network::MessageSink {
 public:
  Gateway(Scheduler& scheduler, TupleSpace& space, base::LogSink& log, GatewayLimits limits = {});
  ~Gateway() override;

  /// Where messages for own networks go (the supervisor); set once, before anything is sent.
  void connect(network::Supervisor& networks);

  /// All messages of this kind that reach this island, from own networks or other islands.
  [[nodiscard]] Handle subscribe(MessageKind kind, MessageCall call);
  /// All Opaque messages with this type tag.
  [[nodiscard]] Handle subscribe_user(std::string_view type, MessageCall call);

  /// To an own network, a local listener (empty network) or another island. Origin and number are set here when origin
  /// is kNoOwner. Delivery happens in a later turn. Returns what an Acknowledge to it names.
  std::uint64_t send(Message message);
  /// Told of each message to another island that it took, by the number that send() returned.
  void on_taken(std::function<void(std::uint64_t number)> call);

  /// Who knows which own networks have a device: messages to a device without a network go to the one that has it, and
  /// are refused where several have.
  using NetworksOf = std::function<std::vector<std::string>(const std::string& device)>;
  void find_devices(NetworksOf networks_of);

  /// Who judges Actuate and SetProperty of others (devices, other islands, components) for devices of own networks, and
  /// answers them; an error is answered here. They never reach a network by themselves (docs/decisions/015).
  using CommandCall = std::function<Result<void>(const Message&)>;
  void take_commands(CommandCall call);

  /// Who undeliverable messages of an own component are reported to is Message.source; answers to this island with an
  /// empty network go to the kAcknowledge listeners.
  void from_network(const std::string& network, Message message) override;

  /// Other bounds from now on; what waits already stays.
  void limit(GatewayLimits limits);
  /// Drops what waits of a network that was removed or is made anew.
  void forget(const std::string& network);

  struct Counters {
    std::uint64_t delivered = 0, dropped_readings = 0, refused_busy = 0, undeliverable = 0, duplicates = 0, looped = 0,
                  malformed = 0, forged = 0;
  };
  Counters counters() const;
  /// Counters of one network's queue.
  Counters counters(const std::string& network) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::gateway
