#include "history/status_tuple.h"

#include <tuple>
#include <utility>

#include "model/json_members.h"

namespace rubicon::history {

namespace {

constexpr Duration kLookAtStateEvery = std::chrono::seconds(1);
constexpr Duration kNumbersEvery = std::chrono::seconds(10);

}  // namespace

StatusTuple::StatusTuple(Scheduler& scheduler, TupleSpace& space, std::string key, const History& history)
    : scheduler_(scheduler), space_(space), key_(std::move(key)), history_(history) {
  look();
}

StatusTuple::~StatusTuple() {
  std::ignore = space_.erase(key_);
}

void StatusTuple::look() {
  timer_ = scheduler_.after(kLookAtStateEvery, [this] { look(); });
  const auto now = scheduler_.now();
  const auto state = history_.state();
  if (state == shown_ && now < numbers_due_) return;
  numbers_due_ = now + kNumbersEvery;
  if (std::exchange(shown_, state).word != state.word) since_ = scheduler_.wall_now();
  auto next = text();
  if (next == text_) return;
  text_ = std::move(next);
  std::ignore = space_.set(key_, text_, {"application/json", {}, {}});
}

std::string StatusTuple::text() const {
  const auto counters = history_.counters();
  return model::dump(nlohmann::ordered_json{{"state", shown_.word},
                                            {"reason", shown_.reason},
                                            {"since", model::seconds_json(since_)},
                                            {"file", history_.path()},
                                            {"bytes", counters.bytes},
                                            {"points", counters.points},
                                            {"dropped", counters.dropped}});
}

}  // namespace rubicon::history
