#pragma once

#include "components/processes.h"
#include "components/report.h"

namespace CLI {
class App;
}

namespace rubicon::bench::sites {

// What processes do in the measurements of this program; each is defined beside its measurement.
Json bare_ping(const Meeting& meeting, const Json& options);
Json bare_pong(const Meeting& meeting, const Json& options);
Json steady_commander(const Meeting& meeting, const Json& options);
Json steady_desk(const Meeting& meeting, const Json& options);
Json idle_island(const Meeting& meeting, const Json& options);
Json many_sites(const Meeting& meeting, const Json& options);
Json lister(const Meeting& meeting, const Json& options);
Json switcher(const Meeting& meeting, const Json& options);

// The measurements, each in a file of its own.
void measure_latency(const Plan& plan, Report& report);
void measure_throughput(const Plan& plan, Report& report);
void measure_remote_sets(const Plan& plan, Report& report);
void measure_join(const Plan& plan, Report& report);
void measure_idle(const Plan& plan, Report& report);
void measure_reading(const Plan& plan, Report& report);
void measure_restarts(const Plan& plan, Report& report);
void measure_death(const Plan& plan, Report& report);
void measure_crowd(const Plan& plan, Report& report);
void measure_sites(const Plan& plan, Report& report);

/// `--sites`, `--daemons`.
void add_options(CLI::App& app);

}  // namespace rubicon::bench::sites
