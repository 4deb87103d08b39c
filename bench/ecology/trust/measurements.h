#pragma once

#include "base/log.h"
#include "base/scheduler.h"
#include "components/processes.h"
#include "components/report.h"
#include "tuples/dds/dds_options.h"

namespace rubicon::bench::trust {

/// As a process of the realm in that folder; its administrators may do everything. Throws if the folder is not good.
void add_to(tuples::dds::DdsOptions& options, const std::string& folder, base::Scheduler& scheduler,
            base::LogSink& log);

// What processes do in single measurements.
Json stayer(const Meeting& meeting, const Json& options);
Json newcomer(const Meeting& meeting, const Json& options);
Json renewer(const Meeting& meeting, const Json& options);
Json reader(const Meeting& meeting, const Json& options);

// Each measures the same without and with trust, in turns. Their figures have both, and what trust costs.
void measure_latency(const Plan& plan, Report& report);
void measure_throughput(const Plan& plan, Report& report);
void measure_remote_sets(const Plan& plan, Report& report);
void measure_meeting(const Plan& plan, Report& report);
void measure_memory(const Plan& plan, Report& report);
void measure_get(const Plan& plan, Report& report);
void measure_crowd(const Plan& plan, Report& report);

/// How long others get nothing of a component whose certificate is renewed.
void measure_renewal(const Plan& plan, Report& report);

}  // namespace rubicon::bench::trust
