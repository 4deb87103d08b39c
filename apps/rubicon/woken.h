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

/// Waking the sensors of more devices than this prints a warning.
inline constexpr std::size_t kManyDevices = 20;

/// Devices of which at least one sensor's value is selected.
std::size_t count_woken(const std::vector<client::Device>& devices, const Selections& selections);

/// Prints a warning in a later turn if the selections wake the sensors of more than kManyDevices devices.
void warn_if_many_wake(Client& client, const Selections& selections);

/// Active subscriptions to many single tuples. Bounded: an island accepts 10,000 subscriptions of one component.
class Wakers {
 public:
  static constexpr std::size_t kMost = 9000;
  using Subscribe = std::function<Handle(const Pattern& exact)>;

  explicit Wakers(Subscribe subscribe, std::size_t most = kMost) : subscribe_(std::move(subscribe)), most_(most) {}

  /// Subscribes to a tuple, once. The first tuple beyond the bound prints a warning.
  void wake(OwnerId owner, std::string_view key);
  void forget(OwnerId owner, std::string_view key);
  /// At least one tuple was not woken.
  bool full() const { return full_; }

 private:
  Subscribe subscribe_;
  std::size_t most_;
  bool full_ = false;
  std::map<std::pair<OwnerId, std::string>, Handle> handles_;
};

}  // namespace rubicon::cli
