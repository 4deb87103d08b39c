#include <functional>
#include <stdexcept>
#include <utility>

#include "components/program.h"
#include "ecology/measurements.h"
#include "tuples/dds/dds_ecology.h"

namespace rubicon::bench {

std::shared_ptr<tuples::Ecology> open_engine(const Meeting& meeting, transport::Loop& loop, base::LogSink& log) {
  const auto post = [&loop](std::function<void()> call) { loop.scheduler().post(std::move(call)); };
  auto ecology = tuples::dds::DdsEcology::open(options_of(meeting), loop.scheduler(), post, log);
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
  return run_components(
      count, values,
      {"Measures the tuple space over DDS with several processes on this host. Prints one JSON object.",
       {{"latency", measure_latency},
        {"throughput", measure_throughput},
        {"remote-sets", measure_remote_sets},
        {"joins", measure_joins},
        {"memory", measure_memory},
        {"crowd", measure_crowd},
        {"churn", measure_churn}},
       {{"holder", holder}, {"taker", taker}, {"keeper", keeper}, {"visitors", visitors}},
       rubicon::tuples::dds::kMaxDomain});
}
