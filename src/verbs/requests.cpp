#include "verbs/requests.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "base/compare_text.h"
#include "base/text.h"

namespace rubicon::verbs {

namespace {

using namespace std::chrono_literals;

/// Longest time to live, and longest lifetime of a value, that a client may ask for.
constexpr Duration kMaxRequest = 24h * 366;
constexpr Duration kMaxInterval = 24h;
/// A shorter heartbeat would keep the loop busy.
constexpr Duration kMinHeartbeat = 10ms;
constexpr std::size_t kMaxMediaType = 127;  // RFC 6838, section 4.2

/// RFC 9110, section 5.6.2
bool is_token(std::string_view text) {
  const auto is_part = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ||
           std::string_view("!#$%&'*+-.^_`|~").find(c) != std::string_view::npos;
  };
  return !text.empty() && std::all_of(text.begin(), text.end(), is_part);
}

/// What was read, unless a member is wrong.
template <class Request>
Result<Request> checked(const Members& members, Request request) {
  if (auto good = members.end(); !good) return fail(std::move(good.error()));
  return request;
}

}  // namespace

std::optional<std::string> media_type_of(std::string_view text) {
  std::string type(base::trimmed(text.substr(0, text.find(';'))));
  std::transform(type.begin(), type.end(), type.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 'a' - 'A') : c; });
  const auto slash = type.find('/');
  const bool is_type = slash != type.npos && type.size() <= kMaxMediaType &&
                       is_token(std::string_view(type).substr(0, slash)) &&
                       is_token(std::string_view(type).substr(slash + 1));
  if (!is_type) return std::nullopt;
  return type;
}

Result<Set> read_set(Members& members, bool append, WallTime now) {
  Set set;
  auto tuple = members.tuple("key");
  set.owner = tuple.owner.value_or(model::kNoOwner);
  set.key = std::move(tuple.key);
  set.value = members.value();
  set.append = append;
  if (!append) set.media_type = "text/plain";
  if (const auto media = members.text_or("media", ""); !media.empty()) {
    const auto type = media_type_of(media);
    if (!type)
      members.fault(fmt::format("media is {}; expected a media type such as text/plain", model::quoted(media)));
    set.media_type = type.value_or("");
  }
  set.time_to_live = members.span_or("ttl", {}, 1s, kMaxRequest);
  set.sequence = members.count("sequence", 0, UINT64_MAX);
  if (append) return checked(members, std::move(set));
  set.user_time = members.time_or("user", {}, now);
  if (members.has("expire")) {
    const auto left = members.time_or("expire", {}, now) - now;  // microseconds: more than a Duration may hold
    if (left > left.zero() && left <= std::chrono::duration_cast<std::chrono::microseconds>(kMaxRequest))
      set.lifetime = left;
    else
      members.fault("expire: expected a time within the next 366 days", ErrorCode::kOutOfRange);
  }
  return checked(members, std::move(set));
}

Result<Subscription> read_subscription(Members& members) {
  Subscription wanted;
  wanted.pattern = members.pattern("pattern");
  if (members.has("min")) wanted.minimum = members.span_or("min", {}, 1ms, kMaxInterval);
  wanted.maximum = members.span_or("max", {}, 1ms, kMaxInterval);
  if (wanted.maximum > Duration(0) && wanted.maximum < kMinHeartbeat)
    members.fault("max: expected at least 10ms, or 0 for never");
  wanted.dead_band = members.number_or("deadband", 0, 0, 1e300);
  wanted.active = members.flag("active");
  wanted.full = members.flag("full");
  if (members.flag("passive") && wanted.active) members.fault("active and passive exclude each other");
  return checked(members, std::move(wanted));
}

Result<Pattern> read_get(Members& members) {
  auto tuple = members.tuple("key");
  return checked(members, std::move(tuple));
}

Result<unsigned> read_unsubscribe(Members& members) {
  const auto number = members.count("subscription", 0, UINT32_MAX);
  if (!members.has("subscription")) members.fault("subscription is missing; expected its number");
  return checked(members, static_cast<unsigned>(number.value_or(0)));
}

std::optional<Naming> naming_of(std::string_view verb) {
  if (verb == "set") return Naming{"key", "command"};
  if (verb == "get" || verb == "append") return Naming{"key", "value"};
  if (verb == "subscribe") return Naming{"pattern", "value"};
  return std::nullopt;
}

Error no_verb(std::string_view verb, const std::vector<std::string>& verbs) {
  const auto near = base::did_you_mean(verb, verbs);
  return {ErrorCode::kInvalid,
          fmt::format("do: unknown verb {}{}{}", model::quoted(verb), near.empty() ? "" : "; ", near)};
}

tuples::SetOptions options_of(const Set& set, std::string_view asker) {
  return {set.media_type, set.user_time, set.lifetime, set.sequence, asker};
}

std::uint64_t send(TupleSpace& space, const Set& set, tuples::ReplyCall call, std::string_view asker) {
  const auto ask = set.append ? &TupleSpace::append_remote : &TupleSpace::set_remote;
  return (space.*ask)(set.owner, set.key, set.value, set.time_to_live, std::move(call), options_of(set, asker));
}

}  // namespace rubicon::verbs
