#include "island/log_tuples.h"

#include <tuple>
#include <utility>

namespace rubicon::island {

namespace {

constexpr Duration kLogPause = std::chrono::milliseconds(250);
/// Between two looks whether a passive subscriber came for lines that are not published yet.
constexpr Duration kLook = std::chrono::seconds(1);

}  // namespace

LogTuples::LogTuples(Scheduler& scheduler, TupleSpace& space, std::string key, LogLines& lines)
    : scheduler_(scheduler), space_(space), key_(std::move(key)), lines_(lines), publish_(scheduler, kLogPause, [this] {
        publish_if_wanted();
      }) {
  publish();
  lines_.on_line([this] { publish_.request(); });
  demand_ = space_.watch_demand({space_.self(), key_}, [this](const tuples::Demand& demand) {
    if (demand.wanted) publish_.call_now();
  });
}

void LogTuples::publish_if_wanted() {
  const auto tuple = space_.find(key_);
  if (tuple && space_.has_subscriber(*tuple)) return publish();
  look_again_ = scheduler_.after(kLook, [this] { publish_.request(); });
}

void LogTuples::publish() {
  look_again_.cancel();
  std::ignore = space_.set(key_, lines_.json(), {"application/json", {}, {}});
}

}  // namespace rubicon::island
