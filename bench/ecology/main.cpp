#include <functional>
#include <stdexcept>
#include <utility>

#include "components/program.h"
#include "ecology/measurements.h"
#include "ecology/trust/measurements.h"
#include "tuples/dds/dds_ecology.h"

namespace rubicon::bench {

std::shared_ptr<tuples::Ecology> open_engine(const Meeting& meeting, transport::Loop& loop, base::LogSink& log) {
  const auto post = [&loop](std::function<void()> call) { loop.scheduler().post(std::move(call)); };
  auto options = options_of(meeting);
  if (!meeting.trust.empty()) trust::add_to(options, meeting.trust, loop.scheduler(), log);
  auto ecology = tuples::dds::DdsEcology::open(options, loop.scheduler(), post, log);
  if (!ecology) throw std::runtime_error(ecology.error().text);
  return std::move(*ecology);
}

tuples::dds::DdsOptions options_of(const Meeting& meeting) {
  tuples::dds::DdsOptions options;
  options.domain = meeting.domain;
  options.tag = meeting.tag;
  return options;
}

}  // namespace rubicon::bench

int main(int count, char** values) {
  using namespace rubicon::bench;
  ComponentProgram program;
  program.purpose = "Measures the tuple space over DDS with several processes on this host. Prints one JSON object.";
  program.measurements = {
      {"latency", measure_latency}, {"throughput", measure_throughput}, {"remote-sets", measure_remote_sets},
      {"joins", measure_joins},     {"memory", measure_memory},         {"crowd", measure_crowd},
      {"churn", measure_churn}};
  program.of_trust = {{"latency", trust::measure_latency},
                      {"throughput", trust::measure_throughput},
                      {"remote-sets", trust::measure_remote_sets},
                      {"meeting", trust::measure_meeting},
                      {"memory", trust::measure_memory},
                      {"get", trust::measure_get},
                      {"crowd", trust::measure_crowd},
                      {"renewal", trust::measure_renewal}};
  program.roles = {{"holder", holder},          {"taker", taker},          {"keeper", keeper},
                   {"visitors", visitors},      {"stayer", trust::stayer}, {"newcomer", trust::newcomer},
                   {"renewer", trust::renewer}, {"reader", trust::reader}};
  program.highest_domain = rubicon::tuples::dds::kMaxDomain;
  return run_components(count, values, program);
}
