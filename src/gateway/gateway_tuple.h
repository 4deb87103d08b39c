#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "base/scheduler.h"
#include "gateway/gateway.h"
#include "gateway/message_rights.h"
#include "rubicon/address.hpp"

namespace rubicon::gateway {

/// Remembers which messages were accepted, so that duplicates that arrive on several ways are ignored. A number counts
/// for one destination only: an island that may relay to some places must not use up the numbers of an origin for all
/// others. Bounded: the last 4096 numbers of the 1024 latest origins.
class SeenMessages {
 public:
  static constexpr std::size_t kNumbers = 4096;
  static constexpr std::size_t kOrigins = 1024;

  SeenMessages();

  bool seen(const Address& to, IslandId origin, std::uint64_t number) const;
  void note(const Address& to, IslandId origin, std::uint64_t number);

 private:
  struct Seen {
    std::uint64_t number = 0, place = 0;
    friend bool operator==(const Seen&, const Seen&) = default;
  };
  struct Window {
    std::uint64_t highest = 0;
    std::vector<Seen> numbers;  ///< a ring once it is full
    std::size_t next = 0;
    std::list<IslandId>::iterator age;
  };
  Window& window(IslandId origin);
  std::uint64_t place_of(const Address& to) const;

  std::uint64_t secret_;  ///< a stranger who does not know it cannot choose two destinations with the same place_of()
  std::unordered_map<IslandId, Window> windows_;
  std::list<IslandId> by_age_;  ///< latest first
};

/// The number that an answer to this message names: the number of the request, or the message's own one.
std::uint64_t answerable_number(const Message& message);

/// What is needed of a sent message to answer it if it cannot be delivered.
struct Envelope {
  explicit Envelope(const Message& message);

  Address source, destination;
  std::uint64_t number = 0;  ///< that an answer names
  bool answerable = true;    ///< an Acknowledge never is
};

/// Sends to other islands through their GATEWAY tuple, and receives through ours, which keeps no value. Programs of the
/// original's release post to RUBICON_GATEWAY.DEVICE instead: both spellings are accepted.
class GatewayTuple {
 public:
  /// A message arrived; an error refuses it.
  using Arrival = std::function<Result<void>(Message message, Relay relay, std::size_t size)>;
  /// A message did not reach its island.
  using Failure = std::function<void(const Envelope& envelope, model::Outcome outcome, std::string why)>;
  /// A message was accepted by its island.
  using Accepted = std::function<void(std::uint64_t number)>;
  /// A component posted a message in the name of another one.
  using Forged = std::function<void(OwnerId from, const std::string& why)>;
  /// A component posted a message in the Java serialisation of the original, which is refused.
  using Foreign = std::function<void(OwnerId from, const std::string& why)>;

  GatewayTuple(TupleSpace& space, const MessageRights& rights, const GatewayLimits& limits, Arrival arrival,
               Failure failure, Forged forged, Foreign foreign);
  ~GatewayTuple();
  GatewayTuple(const GatewayTuple&) = delete;
  GatewayTuple& operator=(const GatewayTuple&) = delete;

  /// If the message cannot be delivered, Failure is called, now or later. The error is the reason why it was not sent.
  Result<void> send(const Message& message);
  /// Another message with this origin, number and destination was noted: counts it. Messages without a number are never
  /// repeated.
  bool is_repeated(const Message& message);
  /// The rights allowed this message, which came for `to`: later ones with its origin and number for there count as
  /// repeated.
  void note(const Message& message, const Address& to);
  void on_accepted(Accepted accepted) { accepted_ = std::move(accepted); }

  Gateway::Counters counters;

 private:
  void accept(std::string_view key);
  tuples::SetDecision receive(const tuples::RemoteSet& request);
  tuples::SetDecision malformed(Error why);
  tuples::SetDecision forged(OwnerId from, Error why);
  void answered(const Envelope& envelope, const tuples::Reply& reply);

  TupleSpace& space_;
  const MessageRights& rights_;
  std::size_t limit_;
  Arrival arrival_;
  Failure failure_;
  Forged forged_;
  Foreign foreign_;
  Accepted accepted_;
  SeenMessages seen_;
  std::size_t under_way_ = 0;
  std::vector<Handle> policies_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::gateway
