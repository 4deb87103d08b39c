#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"

namespace rubicon::networks::log {

/// The networks that a recording was found to hold; at most 1000.
class RecordedNetworks {
 public:
  /// The parts of a key behind the prefix, `wsn-1.7.sensor.light-1.value`: whether they name a network not seen before.
  bool note(const std::vector<std::string_view>& parts);
  std::size_t size() const { return names_.size(); }
  /// That one of them must be chosen, with all their names.
  Error choose() const;

 private:
  std::set<std::string, std::less<>> names_;
};

}  // namespace rubicon::networks::log
