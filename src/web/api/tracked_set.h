#pragma once

#include <memory>
#include <optional>
#include <string>

#include "base/scheduler.h"
#include "client/remote_set_tracker.h"
#include "verbs/requests.h"
#include "web/api/context.h"
#include "web/exchange.h"

namespace rubicon::web::api {

/// A set or an append that a client asks for.
struct SetRequest : verbs::Set {
  Caller caller{};        ///< who asks
  bool is_named = false;  ///< by a name of people, so that the answer says the key
};

/// Carries out a request that the caller may ask for and follows it: the owner's reply, then the states of a
/// `.command`, at least the final one
/// (`applied` where nothing reports states). Destruction ends it without a call; not inside a call. The audit gets the
/// owner's reply in any case.
class TrackedSet {
 public:
  struct Callbacks {
    std::function<void(const tuples::Reply& reply)> replied;                           ///< exactly once, first
    std::function<void(const client::Outcome& outcome, bool is_final)> state_changed;  ///< of an accepted command
  };
  TrackedSet(Context& context, const SetRequest& request, Callbacks calls);

 private:
  TrackedSet(const TrackedSet&) = delete;
  TrackedSet& operator=(const TrackedSet&) = delete;
  void reply(const tuples::Reply& reply);
  void change_state(const client::Outcome& outcome, bool is_final);

  Callbacks callbacks_;
  bool replied_ = false, accepted_ = false, is_command_;
  std::unique_ptr<client::RemoteSetTracker> tracker_;
  base::Lifetime lifetime_;
};

/// Whether a set of the tuple may have states: it is called `.command`.
bool may_have_states(std::string_view key);

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
