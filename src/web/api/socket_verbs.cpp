#include <fmt/format.h>

#include <utility>

#include "base/nearest.h"
#include "model/json_members.h"
#include "web/api/socket.h"
#include "web/api/tuple_forms.h"

namespace rubicon::web::api {

namespace {

constexpr double kDayInMs = 86'400'000;
constexpr Duration kReadingPatience = std::chrono::seconds(3);
constexpr std::size_t kMaxMessageType = 255;

Duration milliseconds_of(double count) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::milli>(count));
}

Duration seconds_of(double count) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(count));
}

constexpr double kLongestSeconds = std::chrono::duration<double>(kLongestRequest).count();
constexpr double kLatestTime = 1e11;  ///< seconds since 1970: the year 5138

FeedOptions read_feed(Members& members) {
  FeedOptions options;
  options.pattern = members.pattern("pattern");
  options.minimum = milliseconds_of(members.number_or("min", 50, 0, kDayInMs));
  options.maximum = milliseconds_of(members.number_or("max", 0, 0, kDayInMs));
  options.dead_band = members.number_or("deadband", 0, 0, 1e300);
  options.active = members.flag_or("active", false);
  const bool both = members.flag_or("passive", false) && options.active;
  if (both) members.fault({ErrorCode::kInvalid, "active and passive exclude each other"});
  return options;
}

SetRequest read_set(Members& members, bool is_append, WallTime now) {
  SetRequest request;
  auto tuple = members.tuple("key");
  request.owner = tuple.owner.value_or(model::kNoOwner);
  request.key = std::move(tuple.key);
  request.value = members.value();
  request.append = is_append;
  request.media_type = members.text_or("media", is_append ? "" : "text/plain");
  request.time_to_live = seconds_of(members.number_or("ttl", 0, 0, kLongestSeconds));
  request.sequence = members.count("sequence", UINT64_MAX);
  if (is_append) return request;
  request.user_time = model::time_from_seconds(members.number_or("user", 0, 0, kLatestTime));
  if (!members.has("expire")) return request;
  request.lifetime = seconds_of(members.number_or("expire", 0, 0, kLatestTime) - base::to_seconds(now));
  if (request.lifetime <= Duration(0) || request.lifetime > kLongestRequest)
    members.fault({ErrorCode::kOutOfRange, "expire: expected a time in seconds since 1970 within the next 366 days"});
  return request;
}

}  // namespace

const std::vector<Socket::VerbName>& Socket::verbs() {
  static const std::vector<VerbName> kVerbs{
      {"subscribe", &Socket::subscribe},
      {"unsubscribe", &Socket::unsubscribe},
      {"get", &Socket::get},
      {"set", &Socket::set},
      {"append", &Socket::append},
      {"send", &Socket::send},
      {"listen", &Socket::listen},
      {"unlisten", &Socket::unlisten},
      {"islands", &Socket::list_islands},
      {"components", &Socket::list_components},
      {"hello", &Socket::hello},
  };
  return kVerbs;
}

Result<void> Socket::request(Id id, const std::string& verb, Members& members) {
  if (caller_.role == Role::kNone && verb != "hello")
    return fail(ErrorCode::kRefused, R"(the first frame must be {"id":1,"do":"hello","token":"..."})");
  std::vector<std::string> names;
  for (const auto& one : verbs()) {
    if (verb != one.name) {
      names.emplace_back(one.name);
      continue;
    }
    members.name(verb);
    return (this->*one.verb)(id, members);
  }
  if (verb.empty()) return members.end();
  const auto near = base::did_you_mean(verb, names);
  return fail(ErrorCode::kInvalid,
              fmt::format("do: unknown verb {}{}{}", model::quoted(verb), near.empty() ? "" : "; ", near));
}

Result<void> Socket::take_command() {
  if (!commands_.take(context_.scheduler.now()))
    return fail(ErrorCode::kBusy, fmt::format("more than {} commands in a second", Context::kCommandsPerSecond));
  if (sets_.size() + readings_.size() + sending_ >= kMaxUnderWay)
    return fail(ErrorCode::kBusy, fmt::format("{} requests are under way; wait for their outcomes", kMaxUnderWay));
  return {};
}

Result<void> Socket::hello(Id id, Members& members) {
  const auto token = members.text("token", "a token");
  if (auto good = members.end(); !good) return good;
  if (context_.access.rules().needs_token) {
    auto known = context_.access.by_token(token, caller_.peer);
    if (!known) {
      if (caller_.role == Role::kNone) calls_.close("the token was not accepted");
      return fail(std::move(known.error()));
    }
    caller_ = std::move(*known);
  }
  hello_time_.clear();
  answer(id, {{"caller", {{"name", caller_.name}, {"role", access::to_string(caller_.role)}}}});
  return {};
}

Result<void> Socket::subscribe(Id id, Members& members) {
  auto options = read_feed(members);
  const bool full = members.flag_or("full", false);
  if (auto good = members.end(); !good) return good;
  const auto owner = options.pattern.owner.value_or(model::kNoOwner);
  const auto& permission = context_.permission;
  if (auto good = permission.check_read(caller_, web::Verb::kRead, owner, options.pattern.key); !good) return good;
  if (options.active) {
    if (auto good = permission.check_read(caller_, web::Verb::kWake, owner, options.pattern.key); !good) return good;
  }
  if (feeds_.size() >= kMaxSubscriptions)
    return fail(ErrorCode::kBusy, fmt::format("{} subscriptions are the most of a connection", kMaxSubscriptions));
  const auto number = ++last_subscription_;
  answer(id, {{"subscription", number}});
  feeds_.emplace(number, std::make_unique<Feed>(context_, caller_, stock_, std::move(options),
                                                std::make_unique<SocketWriter>(number, full),
                                                Feed::Calls{[this] { wake(); }, [this] { merged(); },
                                                            [this](const char* why) { calls_.close(why); }}));
  return {};
}

Result<void> Socket::unsubscribe(Id id, Members& members) {
  const auto number = members.count("subscription", UINT32_MAX);
  if (auto good = members.end(); !good) return good;
  if (!number || feeds_.erase(static_cast<unsigned>(*number)) == 0)
    return fail(ErrorCode::kNotFound, number
                                          ? fmt::format("unsubscribe: this connection has no subscription {}", *number)
                                          : "unsubscribe: subscription is missing; expected its number");
  answer(id);
  return {};
}

Result<void> Socket::get(Id id, Members& members) {
  const auto tuple = members.tuple("key");
  if (auto good = members.end(); !good) return good;
  if (auto good = context_.permission.check_read(caller_, web::Verb::kRead, *tuple.owner, tuple.key); !good)
    return good;
  if (sets_.size() + readings_.size() + sending_ >= kMaxUnderWay)
    return fail(ErrorCode::kBusy, fmt::format("{} requests are under way; wait for their outcomes", kMaxUnderWay));
  const auto found = [this, id, tuple](const std::vector<client::Tuple>& tuples) {
    forget(readings_, id);
    if (tuples.empty()) return refuse(id, {ErrorCode::kNotFound, fmt::format("no tuple {}", to_string(tuple))});
    const auto& one = tuples.front();
    answer(id, {{"tuple", whole_tuple({one.owner, one.key, one.value, one.media_type, one.creator, one.sequence,
                                       one.write_time, one.user_time, one.expire_time, one.owner_present})}});
  };
  readings_.emplace(id, std::make_unique<client::TupleQuery>(context_.scheduler, context_.space, context_.peers, tuple,
                                                             found, kReadingPatience));
  return {};
}

Result<void> Socket::set(Id id, Members& members) {
  return write(id, members, false);
}

Result<void> Socket::append(Id id, Members& members) {
  return write(id, members, true);
}

Result<void> Socket::write(Id id, Members& members, bool is_append) {
  auto request = read_set(members, is_append, context_.scheduler.wall_now());
  if (auto good = members.end(); !good) return good;
  request.caller = caller_;
  if (auto good = context_.permission.check_set(caller_, request, take_command()); !good) return good;
  ++context_.counters.commands;
  TrackedSet::Calls calls{
      [this, id, request](const tuples::Reply& reply) { replied(id, request, reply); },
      [this, id](const client::Outcome& outcome, bool is_final) { state_changed(id, outcome, is_final); }};
  sets_.emplace(id, std::make_unique<TrackedSet>(context_, request, std::move(calls)));
  return {};
}

void Socket::replied(Id id, const SetRequest& request, const tuples::Reply& reply) {
  const auto verdict = verdict_of(reply, request.owner);
  const bool states_follow = may_have_states(request.key) && !request.append;
  if (!verdict || !states_follow) forget(sets_, id);
  if (!verdict) return refuse(id, verdict.error());
  Line line{{"verdict", "applied"}, {"request", reply.request}};
  if (reply.sequence != 0) line["sequence"] = reply.sequence;
  answer(id, std::move(line));
}

void Socket::state_changed(Id id, const client::Outcome& outcome, bool is_final) {
  Line line{{"id", id}, {"state", outcome.state}, {"reason", outcome.reason}, {"request", outcome.request}};
  if (outcome.until != WallTime{}) line["until"] = model::seconds_json(outcome.until);
  if (is_final) line["final"] = true;
  put(model::dump(line));
  if (is_final) forget(sets_, id);
}

/// What reports its end cannot be destroyed during that.
template <class Map>
void Socket::forget(Map& map, Id id) {
  lifetime_.post(context_.scheduler, [&map, id] { map.erase(id); });
}

Result<void> Socket::send(Id id, Members& members) {
  Address to;
  to.island = OwnerId(static_cast<std::uint32_t>(members.count("to", UINT32_MAX).value_or(0)));
  to.network = members.text_or("network", "");
  to.device = members.text_or("device", "");
  const auto type = members.text("type", "the content type of the message, such as knx");
  const auto value = members.value();
  if (to.island == model::kNoOwner) members.fault({ErrorCode::kInvalid, "to: expected the id of a component"});
  if (auto good = members.end(); !good) return good;
  if (auto good = context_.permission.check_send(caller_, to, type, take_command()); !good) return good;
  ++sending_;
  client::SentCall tell = lifetime_.guard([this, id](const std::string& error) {
    --sending_;
    if (error.empty()) return answer(id);
    refuse(id, {ErrorCode::kUnreachable, error});
  });
  context_.messages.send(to, type, value,
                         [tell = std::move(tell),
                          record = context_.permission.send_recorder(caller_, to, type)](const std::string& error) {
                           if (record) record(error);
                           tell(error);
                         });
  return {};
}

Result<void> Socket::listen(Id id, Members& members) {
  const auto type = members.text("type", "the content type of messages, such as knx.telegram");
  if (auto good = members.end(); !good) return good;
  if (auto good = context_.permission.check_listen(caller_, context_.space.self(), type); !good) return good;
  if (type.empty() || type.size() > kMaxMessageType)
    return fail(ErrorCode::kInvalid, fmt::format("listen: type: expected 1 to {} bytes", kMaxMessageType));
  if (listened_.size() >= kMaxListened && !listened_.contains(type))
    return fail(ErrorCode::kBusy, fmt::format("{} types are the most of a connection", kMaxListened));
  listened_[type] =
      context_.messages.on_message(type, [this](const client::UserMessage& message) { message_arrived(message); });
  answer(id);
  return {};
}

Result<void> Socket::unlisten(Id id, Members& members) {
  const auto type = members.text("type", "a type that this connection listens for");
  if (auto good = members.end(); !good) return good;
  if (listened_.erase(type) == 0)
    return fail(ErrorCode::kNotFound,
                fmt::format("unlisten: this connection does not listen for {}", model::quoted(type)));
  answer(id);
  return {};
}

Result<void> Socket::list_islands(Id id, Members& members) {
  if (auto good = members.end(); !good) return good;
  if (auto good = context_.permission.check_read(caller_, web::Verb::kRead, model::kNoOwner, "**"); !good) return good;
  answer(id);
  islands_asked_ = islands_due_ = true;
  watch_components();
  return {};
}

Result<void> Socket::list_components(Id id, Members& members) {
  if (auto good = members.end(); !good) return good;
  if (auto good = context_.permission.check_read(caller_, web::Verb::kRead, model::kNoOwner, "**"); !good) return good;
  answer(id);
  components_asked_ = components_due_ = true;
  watch_components();
  return {};
}

}  // namespace rubicon::web::api
