#pragma once

#include "components/node.h"
#include "components/processes.h"
#include "components/report.h"
#include "tuples/dds/dds_options.h"

namespace CLI {
class App;
}

namespace rubicon::bench {

/// The engine that the meeting names.
std::shared_ptr<tuples::Ecology> open_one(const Meeting& meeting, transport::Loop& loop, base::LogSink& log);
tuples::dds::DdsOptions options_of(const Meeting& meeting);

// What processes do in single measurements.
Json holder(const Meeting& meeting, const Json& options);
Json taker(const Meeting& meeting, const Json& options);
Json keeper(const Meeting& meeting, const Json& options);
Json visitors(const Meeting& meeting, const Json& options);
Json lamp(const Meeting& meeting, const Json& options);
Json switcher(const Meeting& meeting, const Json& options);

/// Half round trips of a Unix stream between two processes, the floor of engine host.
Json bare_ping(const Meeting& meeting, const Json& options);
Json bare_pong(const Meeting& meeting, const Json& options);
/// One of many processes that connect to each other by Unix streams, the floor of a crowd on engine host.
Json bare_member(const Meeting& meeting, const Json& options);

// The measurements, each in a file of its own.
void measure_latency(const Plan& plan, Report& report);
void measure_throughput(const Plan& plan, Report& report);
void measure_remote_sets(const Plan& plan, Report& report);
void measure_joins(const Plan& plan, Report& report);
void measure_memory(const Plan& plan, Report& report);
void measure_crowd(const Plan& plan, Report& report);
void measure_stops(const Plan& plan, Report& report);
/// Of crowd and stops, and `--lease`.
void add_crowd_options(CLI::App& app);
/// The lease of components on DDS, by `--lease`, in seconds.
double& lease_seconds();
void measure_lamp(const Plan& plan, Report& report);
void measure_churn(const Plan& plan, Report& report);

}  // namespace rubicon::bench
