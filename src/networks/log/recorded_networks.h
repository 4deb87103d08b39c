#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"

namespace rubicon::networks::log {

/// The names of the networks in a recording; at most 1000.
class RecordedNetworks {
 public:
  /// Takes the parts of a key after the prefix, `wsn-1.7.sensor.light-1.value`. True: they name a new network.
  bool note(const std::vector<std::string_view>& parts);
  std::size_t size() const { return names_.size(); }
  /// The error that one of them must be chosen, with all names.
  Error ambiguous() const;

 private:
  std::set<std::string, std::less<>> names_;
};

}  // namespace rubicon::networks::log
