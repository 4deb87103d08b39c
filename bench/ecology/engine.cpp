#include <functional>
#include <stdexcept>
#include <utility>

#include "ecology/measurements.h"
#include "ecology/trust/measurements.h"
#include "tuples/dds/dds_ecology.h"

namespace rubicon::bench {

std::shared_ptr<tuples::Ecology> open_dds(const Meeting& meeting, transport::Loop& loop, base::LogSink& log) {
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
