#pragma once

#include <functional>
#include <string>

#include "base/lifetime.h"
#include "gateway/gateway.h"
#include "gateway/seen_messages.h"

namespace rubicon::gateway {

/// What an answer to this message names: the number of its request, or its own where it has none.
std::uint64_t answerable_number(const Message& message);

/// What is kept of a message under way, to answer it when it turns out undeliverable.
struct Envelope {
  explicit Envelope(const Message& message);

  Address source, destination;
  std::uint64_t number = 0;  ///< what an answer names
  bool answerable = true;    ///< an Acknowledge never is
};

/// The ways to and from other islands: their GATEWAY tuple and ours, which takes messages in and keeps no value.
class GatewayTuple {
 public:
  /// A message came in; an error refuses it.
  using Arrival = std::function<Result<void>(Message message, std::size_t size)>;
  /// A message sent did not reach its island.
  using Failure = std::function<void(const Envelope& envelope, model::Outcome outcome, std::string why)>;
  /// A message sent was taken by its island.
  using Taken = std::function<void(std::uint64_t number)>;
  /// A component posted a message in the name of another one.
  using Forged = std::function<void(OwnerId from, const std::string& why)>;

  GatewayTuple(TupleSpace& space, const GatewayLimits& limits, Arrival arrival, Failure failure, Forged forged);
  ~GatewayTuple();
  GatewayTuple(const GatewayTuple&) = delete;
  GatewayTuple& operator=(const GatewayTuple&) = delete;

  void send(const Message& message);
  void on_taken(Taken taken) { taken_ = std::move(taken); }

  Gateway::Counters counters;

 private:
  tuples::SetDecision take(const tuples::RemoteSet& request);
  tuples::SetDecision malformed(Error why);
  tuples::SetDecision forged(OwnerId from, Error why);
  void answered(const Envelope& envelope, const tuples::Reply& reply);

  TupleSpace& space_;
  std::size_t limit_;
  Arrival arrival_;
  Failure failure_;
  Forged forged_;
  Taken taken_;
  SeenMessages seen_;
  std::size_t under_way_ = 0;
  Handle policy_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::gateway
