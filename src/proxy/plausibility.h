#pragma once

#include <optional>
#include <string>

#include "model/point.h"
#include "model/value.h"
#include "proxy/proxy_config.h"

namespace rubicon::proxy {

/// Decides whether the readings of one point can be true. A value beyond `step`, or one that falls although it should
/// rise, is believed when three readings in a row agree: the room did cool down, or the meter was replaced.
class Plausibility {
 public:
  explicit Plausibility(Valid rules) : rules_(std::move(rules)) {}

  const Valid& rules() const { return rules_; }
  /// Why the value is not believed; empty = it is, as every value that is no number. `before`: the last good value.
  std::string objection(const Value& value, std::optional<double> before);

 private:
  std::string doubt(double value, double before) const;
  bool agrees(double value) const;

  Valid rules_;
  std::optional<double> candidate_;  ///< the last doubted value
  int agreeing_ = 0;                 ///< readings in a row that agree with it
};

/// The rules of a point: its own, else those of its type in the network, with the codes known for the type. nullopt:
/// none.
std::optional<Valid> rules_of(const NetworkRules& network, const std::string& address,
                              const model::Capability& capability, const model::Type* type);

}  // namespace rubicon::proxy
