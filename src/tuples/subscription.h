#pragma once

#include <memory>
#include <unordered_map>

#include "tuples/tuple_pool.h"

namespace rubicon::tuples {

struct PeerBox;

/// Where one paced subscription stands with one tuple.
struct Pace {
  SteadyTime last{};                     ///< of the last delivery
  SteadyTime armed = SteadyTime::max();  ///< of the earliest deadline under way
  double number = 0;                     ///< last delivered
  bool has_number = false;
  bool pending = false;  ///< a value waits for the end of the minimum interval
};

/// One subscription, of this component or of a distant one; shared by all subscriber sets it is in. No call is made
/// after it died.
struct Subscription {
  std::uint64_t number = 0;  ///< unique in this space
  std::uint32_t wire_id = 0;
  Pattern pattern;
  Flow flow;
  EventCall call;
  std::function<void(OwnerId)> snapshot;  ///< of a local one: told when an owner told all it has
  std::shared_ptr<PeerBox> peer;          ///< of a distant subscriber; null = local
  std::size_t place = 0;                  ///< among the subscriptions with this very pattern
  bool alive = true;
  bool running = false;  ///< inside its call
  std::unordered_map<std::uint32_t, Pace> paces;

  bool local() const { return peer == nullptr; }
  /// Heartbeats are made by the receiver: a distant subscriber's maximum interval is no matter of ours.
  bool paced() const {
    return flow.minimum > Duration(0) || flow.dead_band > 0 || (local() && flow.maximum > Duration(0));
  }
  void die() {
    alive = false;
    if (!running) call = nullptr;
    paces.clear();
  }
};
using SubscriptionPtr = std::shared_ptr<Subscription>;

}  // namespace rubicon::tuples
