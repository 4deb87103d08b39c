#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "base/scheduler.h"

namespace rubicon::base {

/// Queues whose items expire while they wait: each item has a member `expires` (SteadyTime). One timer serves them all
/// and runs at most once each 10 ms. The code that takes an item checks `expires` again.
template <class Item>
class ExpiringQueues {
 public:
  /// `expired` gets each item whose time is over, outside any call to this; `swept` is called after each pass that
  /// removed some. Neither may destroy this.
  ExpiringQueues(Scheduler& scheduler, std::size_t count, std::function<void(Item)> expired,
                 std::function<void()> swept = {})
      : scheduler_(scheduler),
        queues_(count),
        expired_(std::move(expired)),
        swept_(std::move(swept)),
        next_(scheduler, [this] { sweep(); }) {}
  ExpiringQueues(const ExpiringQueues&) = delete;
  ExpiringQueues& operator=(const ExpiringQueues&) = delete;

  void push_back(std::size_t queue, Item item) {
    next_.advance_to(item.expires);
    queues_.at(queue).push_back(std::move(item));
  }
  void push_front(std::size_t queue, Item item) {
    next_.advance_to(item.expires);
    queues_.at(queue).push_front(std::move(item));
  }
  /// The queue must not be empty.
  Item pop_front(std::size_t queue) {
    auto& items = queues_.at(queue);
    Item item = std::move(items.front());
    items.pop_front();
    return item;
  }

  bool empty(std::size_t queue) const { return queues_.at(queue).empty(); }
  std::size_t size(std::size_t queue) const { return queues_.at(queue).size(); }

 private:
  static constexpr Duration kStep = std::chrono::milliseconds(10);

  void sweep() {
    const auto now = scheduler_.now();
    auto next = SteadyTime::max();
    std::vector<Item> over;
    for (auto& queue : queues_) {
      for (Item& item : queue) {
        if (item.expires <= now) {
          over.push_back(std::move(item));
          item.expires = SteadyTime::min();  // marks an item that was moved away
        } else {
          next = std::min(next, item.expires);
        }
      }
      std::erase_if(queue, [](const Item& item) { return item.expires == SteadyTime::min(); });
    }
    if (next != SteadyTime::max()) next_.set_at(std::max(next, now + kStep));
    for (Item& item : over) expired_(std::move(item));
    if (!over.empty() && swept_) swept_();
  }

  Scheduler& scheduler_;
  std::vector<std::deque<Item>> queues_;
  std::function<void(Item)> expired_;
  std::function<void()> swept_;
  Deadline next_;
};

}  // namespace rubicon::base
