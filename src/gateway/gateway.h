#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
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
  std::size_t devices = 20000;  ///< joins waiting per network, one per device (limits.devices)

  friend bool operator==(const GatewayLimits&, const GatewayLimits&) = default;
};

using MessageCall = std::function<void(const Message&)>;
using tuples::Handle;

/// Routes messages: own networks <-> local listeners <-> other islands through their GATEWAY tuple (D1.4,
/// Implementation). Delivers in a later turn, once and in order per source. A message that cannot be delivered is
/// answered with an Acknowledge{kUndeliverable | kBusy | ..., reason} to its source, unless it is an Acknowledge
/// itself. Where members are known, a message of another component needs the right `send` for where it goes.
class Gateway final : public network::MessageSink {
 public:
  Gateway(Scheduler& scheduler, TupleSpace& space, base::LogSink& log, GatewayLimits limits = {});
  ~Gateway() override;

  /// Messages for own networks go there. Call once, before anything is sent.
  void connect(network::Supervisor& networks);

  /// Subscribes to all messages of this kind that reach this island, from own networks or other islands.
  [[nodiscard]] Handle subscribe(MessageKind kind, MessageCall call);
  /// `call` gets the messages of a network that are routed next, a few at a time, to fetch the memory that they need;
  /// nullptr ends it.
  using NextCall = std::function<void(std::span<const Message>)>;
  void set_look_ahead(NextCall call);
  /// Subscribes to all Opaque messages with this type tag.
  [[nodiscard]] Handle subscribe_user(std::string_view type, MessageCall call);

  /// Sends to an own network, a local listener (empty network) or another island, in a later turn. Sets origin and
  /// number where origin is kNoOwner. Returns the number that an Acknowledge to the message names.
  std::uint64_t send(Message message);
  /// `call` gets the number that send() returned, for each message that another island accepted.
  void on_accepted(std::function<void(std::uint64_t number)> call);

  /// Returns the own networks that have a device. A message to a device without a network goes to the network that has
  /// it, and is refused if several have.
  using NetworksOf = std::function<std::vector<std::string>(const std::string& device)>;
  /// Returns network and device as in the keys of the tuples of a device, `wsn-1.kitchen`; empty: there is none.
  using PartsOf = std::function<std::string(const std::string& network, const std::string& device)>;
  void set_device_lookup(NetworksOf networks_of, PartsOf parts_of = nullptr);

  /// Decides an Actuate or SetProperty from others (devices, other islands, components) for a device of an own network:
  /// accepts and answers it, or refuses it by an error, also if the right `set` is missing. They never reach a network
  /// directly (docs/decisions/015). `through`: the member that handed it on and names its sender; empty = its sender
  /// was here.
  using CommandCall = std::function<Result<void>(const Message&, const std::string& through)>;
  /// Whether the sender of such a message may set the tuple that the message would set. Only a question: the answer is
  /// neither counted nor recorded. If several networks have the device, those are left out where the sender may not.
  using MayCommand = std::function<bool(const Message&)>;
  void set_command_handler(CommandCall call, MayCommand may = nullptr);

  /// A message of an own network. If it cannot be delivered, its Message::source is answered; answers to this island
  /// with an empty network go to the kAcknowledge listeners.
  void from_network(const std::string& network, Message&& message) override;

  /// Sets other bounds; messages that wait already stay.
  void limit(GatewayLimits limits);
  /// Drops the waiting messages of a network that is removed or recreated.
  void forget(const std::string& network);

  struct Counters {
    std::uint64_t delivered = 0, dropped_readings = 0, refused_busy = 0, undeliverable = 0, duplicates = 0, looped = 0,
                  malformed = 0, forged = 0, not_permitted = 0;
  };
  Counters counters() const;
  /// Counters of one network's queue.
  Counters counters(const std::string& network) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::gateway
