#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "tuples/peis/counters.h"
#include "tuples/peis/session.h"

namespace rubicon::tuples::peis {

/// Calls `visit` with the name (`refused-keys`) and the value of each counter.
using CounterVisit = std::function<void(std::string_view name, std::uint64_t value)>;
void each_counter(const Counters& counters, const CounterVisit& visit);
void each_counter(const SessionCounters& counters, const CounterVisit& visit);

}  // namespace rubicon::tuples::peis
