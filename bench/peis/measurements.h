#pragma once

#include "components/node.h"
#include "components/processes.h"
#include "components/report.h"

namespace rubicon::bench {

std::shared_ptr<tuples::Ecology> open_peis(const Meeting& meeting, transport::Loop& loop, base::LogSink& log);

}  // namespace rubicon::bench

namespace rubicon::bench::peis {

// What processes do in the measurements of this program; each is defined beside its measurement.
Json bare_ping(const Meeting& meeting, const Json& options);
Json bare_pong(const Meeting& meeting, const Json& options);
Json bare_source(const Meeting& meeting, const Json& options);
Json bare_sink(const Meeting& meeting, const Json& options);
Json slow_kernel(const Meeting& meeting, const Json& options);

// The measurements, each in a file of its own.
void measure_latency(const Plan& plan, Report& report);
void measure_throughput(const Plan& plan, Report& report);
void measure_remote_sets(const Plan& plan, Report& report);
void measure_join(const Plan& plan, Report& report);
void measure_stall(const Plan& plan, Report& report);
void measure_death(const Plan& plan, Report& report);
void measure_crowd(const Plan& plan, Report& report);
void measure_kernel(const Plan& plan, Report& report);

/// Of PUSH_TUPLE with a value of value_of(), its package header included.
std::size_t bytes_of_push();

}  // namespace rubicon::bench::peis
