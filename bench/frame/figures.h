#pragma once

#include <chrono>
#include <nlohmann/json.hpp>
#include <vector>

namespace rubicon::bench {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

/// 0 for none.
double median(std::vector<double> values);
/// `part` of the values are not above it; 0 <= part <= 1. 0 for none.
double percentile(std::vector<double> values, double part);
double milliseconds(Clock::duration span);
double seconds_since(Clock::time_point start);
/// Rounded to this many decimals.
double rounded(double value, int digits);

}  // namespace rubicon::bench
