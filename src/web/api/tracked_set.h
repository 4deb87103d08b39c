#pragma once

#include <memory>
#include <string>

#include "base/lifetime.h"
#include "client/remote_set_tracker.h"
#include "web/api/context.h"

namespace rubicon::web::api {

/// A set or an append that a client asks for.
struct SetRequest {
  OwnerId owner{};
  std::string key, value;
  std::string media_type{};                      ///< of an append empty = that of the tuple
  WallTime user_time{};                          ///< zero = not given
  Duration lifetime{0};                          ///< of the value; zero = it does not expire
  Duration time_to_live{0};                      ///< of the request; zero = 5 s
  Duration patience = std::chrono::seconds(15);  ///< how long to wait for the outcome of a command that must have ended
  std::optional<std::uint64_t> sequence{};       ///< expected
  bool append = false;
  Caller caller{};  ///< who asks
};

/// Longest time to live, and longest lifetime of a value, that a client may ask for.
inline constexpr Duration kLongestRequest = std::chrono::hours(24 * 366);

/// What a reply says to the client: empty if the owner accepted.
Result<void> verdict_of(const tuples::Reply& reply, OwnerId owner);

/// Carries out a request that the caller may ask for and follows it: the owner's reply, then the states of a
/// `.command`, at least the final one
/// (`applied` where nothing reports states). Destruction ends it without a call; not inside a call. The audit gets the
/// owner's reply in any case.
class TrackedSet {
 public:
  struct Calls {
    std::function<void(const tuples::Reply& reply)> replied;                           ///< exactly once, first
    std::function<void(const client::Outcome& outcome, bool is_final)> state_changed;  ///< of an accepted command
  };
  TrackedSet(Context& context, const SetRequest& request, Calls calls);

 private:
  TrackedSet(const TrackedSet&) = delete;
  TrackedSet& operator=(const TrackedSet&) = delete;
  void reply(const tuples::Reply& reply);
  void change_state(const client::Outcome& outcome, bool is_final);

  Calls calls_;
  bool replied_ = false, accepted_ = false, is_command_;
  std::unique_ptr<client::RemoteSetTracker> tracker_;
  base::Lifetime lifetime_;
};

/// Whether a set of the tuple may have states: it is called `.command`.
bool may_have_states(std::string_view key);

}  // namespace rubicon::web::api
