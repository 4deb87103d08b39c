#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/tuple_space.hpp"
#include "verbs/members.h"

// The requests of docs/api.md, as the WebSocket, REST and the shell of a daemon read them. Each function reads all that
// is left of the members: what it does not know is an error.
namespace rubicon::verbs {

/// The verbs of requests, as the WebSocket knows them; the shell of a daemon knows some of them.
inline constexpr std::string_view kVerbs[] = {"append", "components", "get",       "hello",    "islands",    "listen",
                                              "send",   "set",        "subscribe", "unlisten", "unsubscribe"};

/// A set or an append.
struct Set {
  OwnerId owner{};
  std::string key, value;
  std::string media_type{};                 ///< of an append empty = that of the tuple
  WallTime user_time{};                     ///< zero = not given
  Duration lifetime{0};                     ///< of the value; zero = it does not expire
  Duration time_to_live{0};                 ///< of the request; zero = 5 s
  std::optional<std::uint64_t> sequence{};  ///< expected
  bool append = false;
};
Result<Set> read_set(Members& members, bool append, WallTime now);

struct Subscription {
  Pattern pattern;
  std::optional<Duration> minimum{};  ///< between two deliveries
  Duration maximum{0};                ///< present values are delivered again after this time; zero = never
  double dead_band = 0;               ///< changes of numbers by less than this are not delivered
  bool active = false;                ///< creates demand, at the pace of `minimum`
  bool full = false;                  ///< all that is known of each tuple
};
Result<Subscription> read_subscription(Members& members);

/// The tuple that a client wants to get; it has an owner and no wildcards.
Result<Pattern> read_get(Members& members);
/// The number of the subscription that a client ends.
Result<unsigned> read_unsubscribe(Members& members);

/// The member of a request that names tuples, and the last part of the keys of points that it means: people may have
/// given them names (client/target_search.h), which are resolved before the members are read. nullopt: none does.
struct Naming {
  const char* member;
  std::string_view last;
};
std::optional<Naming> naming_of(std::string_view verb);

/// The error of a verb that is none of these.
Error no_verb(std::string_view verb, const std::vector<std::string>& verbs);

/// The media type of a text, without parameters, in lower case (RFC 9110, section 8.3); nullopt for what is none.
std::optional<std::string> media_type_of(std::string_view text);

/// Asks the owner; `asker` is SetOptions::asker. The views of the options belong to the set and to `asker`.
tuples::SetOptions options_of(const Set& set, std::string_view asker = {});
std::uint64_t send(TupleSpace& space, const Set& set, tuples::ReplyCall call, std::string_view asker = {});

}  // namespace rubicon::verbs
