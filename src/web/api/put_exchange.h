#pragma once

#include <optional>

#include "base/lifetime.h"
#include "web/api/tracked_set.h"
#include "web/exchange.h"

namespace rubicon::web::api {

/// Answers a PUT with the outcome of the set. A command whose state is not final after `wait` is answered with that
/// state, and goes on; so is a request that the owner has not replied to, after 5 s at the earliest.
class PutExchange final : public Exchange {
 public:
  PutExchange(Context& context, SetRequest request, Duration wait, Respond respond);

 private:
  void replied(const tuples::Reply& reply);
  void finish(std::optional<Error> error = {});

  Context& context_;
  SetRequest request_;
  Duration wait_;
  Respond respond_;
  SteadyTime start_;
  client::Outcome outcome_;
  Timer patience_;
  std::unique_ptr<TrackedSet> set_;
  base::Lifetime lifetime_;
};

/// The status of an answer that reports the outcome of a set.
unsigned status_of_outcome(std::string_view state);

}  // namespace rubicon::web::api
