#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/rubicon/selection.h"
#include "rubicon/client.hpp"

namespace rubicon::cli {

/// More devices than this are not woken without a word.
inline constexpr std::size_t kManyDevices = 20;

/// Devices of which at least one sensor's value is selected.
std::size_t woken_devices(const std::vector<client::Device>& devices, const Selections& selections);

/// Says on standard error, in a later turn of the loop, how many devices these wake, if they are many.
void tell_who_wakes(Client& client, const Selections& selections);

/// An active subscription for each of many tuples: islands take 10,000 of one component, and it has others.
class Wakers {
 public:
  static constexpr std::size_t kMost = 9000;
  using Subscribe = std::function<Handle(const Pattern& exact)>;

  explicit Wakers(Subscribe subscribe, std::size_t most = kMost) : subscribe_(std::move(subscribe)), most_(most) {}

  /// Subscribes to a tuple, once. When the first tuple finds no room, says so on standard error.
  void wake(OwnerId owner, std::string_view key);
  void forget(OwnerId owner, std::string_view key);
  /// A tuple found no room.
  bool full() const { return full_; }

 private:
  Subscribe subscribe_;
  std::size_t most_;
  bool full_ = false;
  std::map<std::pair<OwnerId, std::string>, Handle> handles_;
};

}  // namespace rubicon::cli
