#pragma once

#include "frame/figures.h"

namespace rubicon::bench::history {

struct Plan {
  int series = 10'000;  ///< each with a value every ten seconds
  int hours = 24;
  int days = 30;  ///< of one series with a value every second
};

/// Many series at once: size, rate, a question after a day, the start after that.
void measure_day(const Plan& plan, Json& out);
/// One series for long.
void measure_month(const Plan& plan, Json& out);

}  // namespace rubicon::bench::history
