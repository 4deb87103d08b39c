#pragma once

#include <memory>
#include <unordered_map>
#include <vector>

#include "tuples/tuple_pool.h"

namespace rubicon::tuples {

struct PeerQueue;

/// State of one paced subscription for one tuple.
struct Pace {
  SteadyTime last{};                     ///< of the last delivery
  SteadyTime armed = SteadyTime::max();  ///< earliest pending deadline
  double number = 0;                     ///< last delivered value
  bool has_number = false;
  bool pending = false;  ///< a value waits for the end of the minimum interval
};

/// One subscription, of this component or of a distant one; shared by all subscriber sets that contain it. No call is
/// made after die().
struct Subscription {
  std::uint64_t number = 0;  ///< unique in this space
  std::uint32_t wire_id = 0;
  Pattern pattern;
  Flow flow;
  EventCall call;
  std::function<void(OwnerId)> snapshot;  ///< local only: called when all tuples of an owner have arrived
  std::shared_ptr<PeerQueue> peer;        ///< queue of a distant subscriber; null = local
  std::size_t place = 0;                  ///< position among the subscriptions with the same pattern
  bool judged = false;                    ///< of a distant subscriber whose rights differ between tuples
  /// The same subscription with less demand, for the tuples where the subscriber has no right to more.
  std::vector<std::shared_ptr<Subscription>> variants;
  bool used = false;           ///< of a variant: a tuple got it since the last kRejudge walk began
  std::uint32_t rejudges = 0;  ///< kRejudge walks that are under way
  bool alive = true;
  bool running = false;  ///< inside its call
  std::unordered_map<std::uint32_t, Pace> paces;

  bool local() const { return peer == nullptr; }
  /// The receiver makes heartbeats: the maximum interval of a distant subscriber does not count here.
  bool paced() const {
    return flow.minimum > Duration(0) || flow.dead_band > 0 || (local() && flow.maximum > Duration(0));
  }
  void die() {
    alive = false;
    if (!running) call = nullptr;
    paces.clear();
    for (const auto& variant : variants) variant->die();
  }
};
using SubscriptionPtr = std::shared_ptr<Subscription>;

}  // namespace rubicon::tuples
