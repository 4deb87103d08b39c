#include "web/api/tuple_read.h"

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

namespace rubicon::web::api {

namespace {

constexpr Duration kPatience = std::chrono::seconds(3);

}  // namespace

TupleRead::TupleRead(Context& context, const std::vector<Pattern>& patterns, Make make, Respond respond)
    : open_(patterns.size()), make_(std::move(make)), respond_(std::move(respond)) {
  for (const auto& pattern : patterns) {
    queries_.push_back(std::make_unique<client::TupleQuery>(
        context.scheduler, context.space, context.peers, pattern,
        [this](std::vector<client::Tuple> some) { add(std::move(some)); }, kPatience));
  }
}

void TupleRead::add(std::vector<client::Tuple> some) {
  std::move(some.begin(), some.end(), std::back_inserter(tuples_));
  if (--open_ > 0) return;
  if (queries_.size() > 1) merge();
  const auto respond = std::move(respond_);
  respond(make_(std::move(tuples_)));  // may destroy this
}

/// A tuple may match several patterns.
void TupleRead::merge() {
  const auto place = [](const client::Tuple& tuple) { return std::tie(tuple.owner, tuple.key); };
  std::sort(tuples_.begin(), tuples_.end(), [&](const auto& a, const auto& b) { return place(a) < place(b); });
  const auto same = [&](const auto& a, const auto& b) { return place(a) == place(b); };
  tuples_.erase(std::unique(tuples_.begin(), tuples_.end(), same), tuples_.end());
}

}  // namespace rubicon::web::api
