#include <fmt/format.h>

#include <utility>

#include "base/compare_text.h"
#include "model/json_members.h"
#include "web/api/forms.h"
#include "web/api/socket.h"

namespace rubicon::web::api {

namespace {

constexpr Duration kReadingPatience = std::chrono::seconds(3);
constexpr std::size_t kMaxMessageType = 255;

Result<void> check_under_way(std::size_t count) {
  if (count < Socket::kMaxUnderWay) return {};
  return fail(ErrorCode::kBusy,
              fmt::format("{} requests are under way; wait for their outcomes", Socket::kMaxUnderWay));
}

}  // namespace

std::span<const Socket::VerbName> Socket::verbs() {
  static constexpr VerbName kAll[] = {
      {"subscribe", &Socket::subscribe},
      {"unsubscribe", &Socket::unsubscribe},
      {"get", &Socket::get},
      {"set", &Socket::write},
      {"append", &Socket::write},
      {"send", &Socket::send},
      {"listen", &Socket::listen},
      {"unlisten", &Socket::unlisten},
      {"islands", &Socket::list_islands},
      {"components", &Socket::list_components},
      {"hello", &Socket::hello},
  };
  static_assert(std::size(kAll) == std::size(verbs::kVerbs));
  return kAll;
}

Result<void> Socket::request(Id id, const std::string& verb, verbs::Members& members) {
  if (caller_.role == Role::kNone && verb != "hello")
    return fail(ErrorCode::kRefused, R"(the first frame must be {"id":1,"do":"hello","token":"..."})");
  const auto waits = look_up(id, verb, members);
  if (!waits) return fail(waits.error());
  if (*waits) return {};
  for (const auto& one : verbs()) {
    if (verb == one.name) return (this->*one.verb)(id, members);
  }
  if (verb.empty()) return members.end();
  return fail(verbs::no_verb(verb, {std::begin(verbs::kVerbs), std::end(verbs::kVerbs)}));
}

Result<bool> Socket::look_up(Id id, const std::string& verb, const verbs::Members& members) {
  const auto naming = verbs::naming_of(verb);
  const auto text = naming ? members.peek(naming->member) : std::string();
  const auto is_name = verb == "subscribe" ? client::is_name_among_patterns : client::is_name;
  if (text.empty() || members.is_resolved() || !is_name(context_.space, text)) return false;
  if (auto good = check_under_way(under_way()); !good) return fail(good.error());
  if (auto good = NameSearch::allow(context_, caller_name_of(caller_)); !good) return fail(good.error());
  const auto found = [this, id, verb, text, copy = verbs::Members(members),
                      member = naming->member](const Result<client::Target>& key) mutable {
    lifetime_.post(context_.scheduler, [search = std::move(waiting_[id])] {});  // not destroyed during its call
    waiting_.erase(id);
    const bool stays = !key && verb == "subscribe" && key.error().code == ErrorCode::kNotFound && Pattern::parse(text);
    if (!key && !stays) return refuse(id, key.error());
    copy.resolve(member, key ? to_string(*key) : text);
    if (const auto done = request(id, verb, copy); !done) refuse(id, done.error());
  };
  waiting_.emplace(id, std::make_shared<NameSearch>(context_, caller_, text, naming->last, found));
  return true;
}

Result<void> Socket::take_command() {
  if (!commands_.take(context_.scheduler.now()))
    return fail(ErrorCode::kBusy, fmt::format("more than {} commands in a second", Context::kCommandsPerSecond));
  return check_under_way(under_way());
}

Result<void> Socket::hello(Id id, verbs::Members& members) {
  const auto token = members.text("token", "a token");
  if (auto good = members.end(); !good) return good;
  if (context_.access.rules().needs_token) {
    auto known = context_.access.by_token(token, caller_.peer);
    if (!known) {
      if (caller_.role == Role::kNone) callbacks_.close("the token was not accepted");
      return fail(std::move(known.error()));
    }
    caller_ = std::move(*known);
  }
  hello_time_.clear();
  answer(id, {{"caller", {{"name", caller_.name}, {"role", access::to_string(caller_.role)}}}});
  return {};
}

Result<void> Socket::subscribe(Id id, verbs::Members& members) {
  auto wanted = verbs::read_subscription(members);
  if (!wanted) return fail(wanted.error());
  const auto owner = wanted->pattern.owner.value_or(model::kNoOwner);
  const auto& permission = context_.permission;
  if (auto good = permission.check_read(caller_, web::Verb::kRead, owner, wanted->pattern.key); !good) return good;
  if (wanted->active) {
    if (auto good = permission.check_read(caller_, web::Verb::kWake, owner, wanted->pattern.key); !good) return good;
  }
  if (feeds_.size() >= kMaxSubscriptions)
    return fail(ErrorCode::kBusy, fmt::format("{} subscriptions are the most of a connection", kMaxSubscriptions));
  const auto number = ++last_subscription_;
  Line line{{"subscription", number}};
  if (members.is_resolved()) line["pattern"] = to_string(wanted->pattern);
  answer(id, line);
  const bool full = wanted->full;
  feeds_.emplace(number, std::make_unique<Feed>(context_, caller_, stock_, std::move(*wanted),
                                                std::make_unique<SocketWriter>(number, full),
                                                Feed::Callbacks{[this] { wake(); }, [this] { merged(); },
                                                                [this](const char* why) { callbacks_.close(why); }}));
  return {};
}

Result<void> Socket::unsubscribe(Id id, verbs::Members& members) {
  const auto number = verbs::read_unsubscribe(members);
  if (!number) return fail(number.error());
  if (feeds_.erase(*number) == 0) return fail(ErrorCode::kNotFound, fmt::format("no subscription {}", *number));
  answer(id);
  return {};
}

Result<void> Socket::get(Id id, verbs::Members& members) {
  const auto tuple = verbs::read_get(members);
  if (!tuple) return fail(tuple.error());
  if (auto good = context_.permission.check_read(caller_, web::Verb::kRead, *tuple->owner, tuple->key); !good)
    return good;
  if (auto good = check_under_way(under_way()); !good) return good;
  const auto found = [this, id, tuple = *tuple](const std::vector<client::Tuple>& tuples) {
    forget(waiting_, id);
    if (tuples.empty()) return refuse(id, verbs::no_tuple(context_.space, tuple));
    answer(id, {{"tuple", tuple_json(tuples.front())}});
  };
  waiting_[id] = std::make_shared<client::TupleQuery>(context_.scheduler, context_.space, context_.peers, *tuple, found,
                                                      kReadingPatience);
  return {};
}

/// `set` and `append`.
Result<void> Socket::write(Id id, verbs::Members& members) {
  auto set = verbs::read_set(members, members.peek("do") == "append", context_.scheduler.wall_now());
  if (!set) return fail(set.error());
  const SetRequest request{std::move(*set), caller_, members.is_resolved()};
  if (auto good = context_.permission.check_set(caller_, request, take_command()); !good) return good;
  ++context_.counters.commands;
  TrackedSet::Callbacks calls{
      [this, id, request](const tuples::Reply& reply) { replied(id, request, reply); },
      [this, id](const client::Outcome& outcome, bool is_final) { state_changed(id, outcome, is_final); }};
  sets_.emplace(id, std::make_unique<TrackedSet>(context_, request, std::move(calls)));
  return {};
}

void Socket::replied(Id id, const SetRequest& request, const tuples::Reply& reply) {
  const auto verdict = verbs::verdict_of(reply, request.owner);
  const bool states_follow = may_have_states(request.key) && !request.append;
  if (!verdict || !states_follow) forget(sets_, id);
  if (!verdict) return refuse(id, verdict.error(), verbs::reply_json(reply));
  auto line = verbs::reply_json(reply);
  if (request.is_named) line["key"] = to_string(client::Target{request.owner, request.key});
  answer(id, line);
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

Result<void> Socket::send(Id id, verbs::Members& members) {
  Address to;
  to.island = OwnerId(static_cast<std::uint32_t>(members.count("to", 0, UINT32_MAX).value_or(0)));
  to.network = members.text_or("network", "");
  to.device = members.text_or("device", "");
  const auto type = members.text("type", "the content type of the message, such as knx");
  const auto value = members.value();
  if (to.island == model::kNoOwner) members.fault("to: expected the id of a component");
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

Result<void> Socket::listen(Id id, verbs::Members& members) {
  const auto type = members.text("type", "the content type of messages, such as knx.telegram");
  if (auto good = members.end(); !good) return good;
  if (auto good = context_.permission.check_listen(caller_, context_.space.self(), type); !good) return good;
  if (type.empty() || type.size() > kMaxMessageType)
    return fail(ErrorCode::kInvalid, fmt::format("type: expected 1 to {} bytes", kMaxMessageType));
  if (listened_.size() >= kMaxListened && !listened_.contains(type))
    return fail(ErrorCode::kBusy, fmt::format("{} types are the most of a connection", kMaxListened));
  listened_[type] =
      context_.messages.on_message(type, [this](const client::UserMessage& message) { message_arrived(message); });
  answer(id);
  return {};
}

Result<void> Socket::unlisten(Id id, verbs::Members& members) {
  const auto type = members.text("type", "a type that this connection listens for");
  if (auto good = members.end(); !good) return good;
  if (listened_.erase(type) == 0)
    return fail(ErrorCode::kNotFound, fmt::format("this connection does not listen for {}", model::quoted(type)));
  answer(id);
  return {};
}

Result<void> Socket::list_islands(Id id, verbs::Members& members) {
  if (auto good = members.end(); !good) return good;
  if (auto good = context_.permission.check_read(caller_, web::Verb::kRead, model::kNoOwner, "**"); !good) return good;
  answer(id);
  islands_asked_ = islands_due_ = true;
  watch_components();
  return {};
}

Result<void> Socket::list_components(Id id, verbs::Members& members) {
  if (auto good = members.end(); !good) return good;
  if (auto good = context_.permission.check_read(caller_, web::Verb::kRead, model::kNoOwner, "**"); !good) return good;
  answer(id);
  components_asked_ = components_due_ = true;
  watch_components();
  return {};
}

}  // namespace rubicon::web::api
