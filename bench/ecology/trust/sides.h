#pragma once

#include <functional>
#include <string>
#include <vector>

#include "components/processes.h"
#include "components/report.h"

namespace rubicon::bench::trust {

/// The results of one measurement, without and with trust.
class Sides {
 public:
  /// Runs both in each round; the one that was first is second in the next.
  static Sides measured(const Plan& plan, int rounds, const std::function<Json(const Meeting&)>& run);

  double plain(const std::string& name) const { return median_of(plain_, name); }
  double secure(const std::string& name) const { return median_of(secure_, name); }
  /// Median over the rounds of secure to plain: what disturbs the machine for longer than a round disturbs both.
  double ratio(const std::string& name) const;
  /// Medians of a number that all rounds have, and their ratio.
  Json figure(const std::string& name, int digits) const;
  /// The results of each round.
  Json rounds() const { return {{"plain", plain_}, {"secure", secure_}}; }

 private:
  static double median_of(const std::vector<Json>& rounds, const std::string& name);

  std::vector<Json> plain_, secure_;
};

}  // namespace rubicon::bench::trust
