#include "native/component.h"

#include <chrono>
#include <utility>

#include "native/options.h"

namespace rubicon::python {

namespace {

Duration duration_of(double seconds) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds));
}

py::dict error_answer(std::string_view code, const std::string& text) {
  py::dict error(py::arg("code") = std::string(code), py::arg("text") = text);
  return py::dict(py::arg("ok") = false, py::arg("error") = std::move(error));
}

py::dict row_of(const client::Tuple& tuple) {
  return py::dict(py::arg("owner") = model::number(tuple.owner), py::arg("key") = tuple.key,
                  py::arg("value") = text_or_none(tuple.value), py::arg("media") = tuple.media_type,
                  py::arg("sequence") = tuple.sequence, py::arg("write") = seconds_of(tuple.write_time),
                  py::arg("user") = seconds_of(tuple.user_time));
}

py::dict answer_of(const client::Outcome& outcome, bool is_final) {
  py::dict answer(py::arg("state") = outcome.state, py::arg("reason") = outcome.reason,
                  py::arg("request") = outcome.request);
  if (outcome.until != WallTime{}) answer["until"] = seconds_of(outcome.until);
  if (is_final) answer["final"] = true;
  return answer;
}

py::dict answer_of(const Reply& reply, OwnerId owner) {
  const auto who = std::to_string(model::number(owner));
  const auto not_applied = [&](std::string_view code, const std::string& text) {
    auto answer = error_answer(code, text);
    answer["verdict"] = std::string(to_string(reply.verdict));
    answer["request"] = reply.request;
    return answer;
  };
  switch (reply.verdict) {
    case Verdict::kApplied:
      return py::dict(py::arg("state") = "applied", py::arg("request") = reply.request,
                      py::arg("sequence") = reply.sequence, py::arg("final") = true);
    case Verdict::kRefused: return not_applied(base::to_string(reply.code), reply.text);
    case Verdict::kNoSuchOwner: return not_applied("not-found", "no component " + who + " is present");
    case Verdict::kExpired:
    case Verdict::kTimedOut: break;
  }
  return not_applied("expired", "component " + who + ": " + reply.text);
}

py::dict message_of(const client::UserMessage& message) {
  return py::dict(py::arg("from") = model::number(message.from), py::arg("type") = message.type,
                  py::arg("value") = py::bytes(message.bytes), py::arg("network") = message.network,
                  py::arg("device") = message.device);
}

py::dict row_of_set(const tuples::RemoteSet& set) {
  return py::dict(py::arg("from") = model::number(set.from), py::arg("key") = set.key,
                  py::arg("value") = py::bytes(set.value), py::arg("media") = set.media_type,
                  py::arg("append") = set.append, py::arg("asker") = set.asker);
}

/// A judge that fails refuses; what it raised is printed as that of a destructor is.
tuples::SetDecision decide(const py::function& call, const tuples::RemoteSet& set) {
  try {
    const py::object why_not = call(row_of_set(set));
    if (why_not.is_none()) return tuples::SetDecision::applied();
    return tuples::SetDecision::refused({ErrorCode::kRefused, py::str(why_not)});
  } catch (py::error_already_set& error) {
    error.discard_as_unraisable(call);
    return tuples::SetDecision::refused({ErrorCode::kRefused, "the judge of " + set.key + " failed"});
  }
}

}  // namespace

Component::Component(const py::dict& options) : client_(value_or_raise(Client::open(options_of(options)))) {
  peers_ = client_->tuples().watch_peers([this](OwnerId peer, PeerEvent event) { peer_changed(peer, event); });
}

Component::~Component() {
  close();
}

void Component::close() {
  if (inside_) raise({ErrorCode::kInvalid, "a judge may not close its space"});
  subscriptions_.clear();
  handles_.clear();
  peers_.reset();
  due_.clear();
  client_.reset();
}

void Component::check() const {
  if (!client_) raise({ErrorCode::kInvalid, "this space is closed; open another one"});
}

void Component::poll() {
  if (!client_) return;
  inside_ = true;
  client_->poll();
  inside_ = false;
  auto due = std::exchange(due_, {});
  for (auto call = due.begin(); call != due.end(); ++call) {
    try {
      (*call)();
    } catch (...) {
      due_.insert(due_.begin(), std::next(call), due.end());
      throw;
    }
  }
  std::vector<std::uint64_t> frames;
  for (const auto& [number, subscription] : subscriptions_) {
    if (subscription->due()) frames.push_back(number);
  }
  for (const auto number : frames) {  // one may end others
    if (const auto found = subscriptions_.find(number); found != subscriptions_.end()) found->second->flush();
  }
}

void Component::peer_changed(OwnerId peer, PeerEvent event) {
  for (const auto& [number, subscription] : subscriptions_) subscription->peer_changed(peer, event == PeerEvent::kUp);
}

py::list Component::islands() const {
  check();
  py::list rows;
  for (const auto& [id, summary] : client_->islands()) {
    std::uint64_t devices = 0;
    py::dict networks;
    for (const auto& [name, count] : summary.networks) {
      networks[py::str(name)] = count;
      devices += count;
    }
    const auto blank = summary.program.find(' ');
    const auto version = blank == std::string::npos ? "" : summary.program.substr(blank + 1);
    rows.append(py::dict(py::arg("id") = model::number(id), py::arg("name") = summary.name,
                         py::arg("host") = summary.host, py::arg("program") = summary.program.substr(0, blank),
                         py::arg("version") = version, py::arg("prefix") = summary.prefix,
                         py::arg("networks") = networks, py::arg("devices") = devices,
                         py::arg("since") = seconds_of(summary.since)));
  }
  return rows;
}

void Component::read(const std::string& pattern, double timeout, py::function call) {
  check();
  const auto found = [this, call = std::move(call)](std::vector<client::Tuple> tuples) {
    later([call, tuples = std::move(tuples)] {
      py::list rows;
      for (const auto& tuple : tuples) rows.append(row_of(tuple));
      call(rows);
    });
  };
  client_->read(value_or_raise(Pattern::parse(pattern)), found, duration_of(timeout));
}

std::uint64_t Component::subscribe(const std::string& pattern, const py::dict& flow, bool full, py::function call) {
  check();
  auto subscription = std::make_unique<Subscription>(client_->tuples(), value_or_raise(Pattern::parse(pattern)),
                                                     flow_of(flow), full, std::move(call));
  subscriptions_.emplace(++last_, std::move(subscription));
  return last_;
}

void Component::write(std::uint32_t owner, const std::string& key, const std::string& value, const py::dict& options,
                      py::function call) {
  check();
  const bool is_append = flag(options, "append");
  if (!is_append && key.ends_with(".command")) return command(owner, key, value, options, call);
  const auto media_type = text(options, "media", is_append ? "" : "text/plain");
  SetOptions set;
  set.media_type = media_type;
  set.user_time = wall_time(seconds(options, "user"));
  set.lifetime = duration_of(seconds(options, "lifetime"));
  if (options.contains("sequence")) set.expected_sequence = options["sequence"].cast<std::uint64_t>();
  const auto replied = [this, owner, call = std::move(call)](const Reply& reply) {
    later([call, reply, owner] { call(answer_of(reply, OwnerId{owner})); });
  };
  const auto time_to_live = duration_of(seconds(options, "ttl"));
  if (is_append)
    client_->tuples().append_remote(OwnerId{owner}, key, value, time_to_live, replied, set);
  else
    client_->tuples().set_remote(OwnerId{owner}, key, value, time_to_live, replied, set);
}

void Component::command(std::uint32_t owner, const std::string& key, const std::string& value, const py::dict& options,
                        const py::function& call) {
  const auto report = [this, call](bool is_final) {
    return [this, call, is_final](const client::Outcome& outcome) {
      later([call, outcome, is_final] { call(answer_of(outcome, is_final)); });
    };
  };
  client_->command(OwnerId{owner}, key, value, report(true), duration_of(seconds(options, "ttl")),
                   std::chrono::seconds(15), report(false));
}

std::uint64_t Component::own(const std::string& key, const std::string& value, const std::string& media_type,
                             double lifetime) {
  check();
  SetOptions options;
  options.media_type = media_type;
  options.lifetime = duration_of(lifetime);
  value_or_raise(client_->tuples().set(key, value, options));
  const auto tuple = client_->tuples().get(client_->id(), key);
  return tuple ? tuple->sequence : 0;
}

void Component::erase(const std::string& key) {
  check();
  if (const auto done = client_->tuples().erase(key); !done) raise(done.error());
}

std::uint64_t Component::judge(const std::string& pattern, bool appends, py::function call) {
  check();
  const auto policy = [call = std::move(call)](const tuples::RemoteSet& set) { return decide(call, set); };
  return keep(
      client_->tuples().add_policy(value_or_raise(Pattern::parse(pattern)), policy,
                                   appends ? tuples::PolicyScope::kSetsAndAppends : tuples::PolicyScope::kSets));
}

void Component::send(std::uint32_t to, const std::string& type, const std::string& data, const std::string& network,
                     const std::string& device, py::function call) {
  check();
  const auto sent = [this, call = std::move(call)](const std::string& error) { later([call, error] { call(error); }); };
  if (!device.empty())
    client_->send_to_device(OwnerId{to}, network, device, type, data, sent);
  else if (!network.empty())
    client_->send_to_network(OwnerId{to}, network, type, data, sent);
  else
    client_->send(OwnerId{to}, type, data, sent);
}

std::uint64_t Component::listen(const std::string& type, py::function call) {
  check();
  return keep(client_->on_message(type, [this, call = std::move(call)](const client::UserMessage& message) {
    later([call, message] { call(message_of(message)); });
  }));
}

std::uint64_t Component::keep(Handle handle) {
  handles_.emplace(++last_, std::move(handle));
  return last_;
}

void Component::end(std::uint64_t what) {
  subscriptions_.erase(what);
  handles_.erase(what);
}

}  // namespace rubicon::python
