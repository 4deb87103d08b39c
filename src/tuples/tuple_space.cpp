#include "tuples/tuple_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

namespace rubicon::tuples {

void Handle::reset() {
  if (auto end = std::exchange(end_, nullptr)) end();
}

Handle& Handle::operator=(Handle&& other) noexcept {
  if (this != &other) {
    reset();
    end_ = std::exchange(other.end_, nullptr);
  }
  return *this;
}

struct TupleSpace::Parts {
  struct Tuple {
    std::string value, media_type;
    TupleView view;
    TupleRef ref;
    std::uint64_t version = 0;
  };
  struct Subscription {
    OwnerId who{};
    std::uint32_t id = 0;
    Pattern pattern;
    Flow flow;
    EventCall call;
  };
  struct Watch {
    Pattern pattern;
    DemandCall call;
    std::map<std::string, std::pair<bool, Duration>> last;
  };
  struct Request {
    ReplyCall call;
    Timer timer;
  };
  using Name = std::pair<OwnerId, std::string>;

  Parts(OwnerId s, Scheduler& sc, Link& l) : self(s), scheduler(sc), link(l) {}

  OwnerId self;
  Scheduler& scheduler;
  Link& link;
  std::map<Name, Tuple> tuples;
  std::map<std::uint32_t, std::string> own_by_index;
  std::uint32_t next_index = 0;
  std::map<std::uint32_t, std::shared_ptr<Subscription>> local;
  std::map<std::pair<OwnerId, std::uint32_t>, std::shared_ptr<Subscription>> distant;
  std::vector<std::shared_ptr<Watch>> watches;
  std::vector<std::pair<Pattern, std::shared_ptr<Judge>>> judges;
  std::vector<std::shared_ptr<PeerCall>> peer_calls;
  std::map<std::uint64_t, Request> requests;
  std::map<std::string, Timer> expiry;
  std::shared_ptr<bool> alive = std::make_shared<bool>(true);
  std::uint32_t next_id = 1;
  std::uint64_t next_request = 1;
  std::uint64_t sets = 0, events = 0;
  bool demand_posted = false;

  template <class Call>
  void later(Call call) {
    scheduler.post([live = std::weak_ptr<bool>(alive), call = std::move(call)] {
      if (live.lock()) call();
    });
  }

  void tell(const std::shared_ptr<Subscription>& s, EventKind kind, const Tuple& t) {
    ++events;
    struct Copy {
      EventKind kind;
      TupleView view;
      std::string key, value, media;
    };
    auto copy = std::make_shared<Copy>(Copy{kind, t.view, std::string(t.view.key), t.value, t.media_type});
    later([this, weak = std::weak_ptr<Subscription>(s), copy] {
      auto still = weak.lock();
      if (!still) return;
      Event event{copy->kind, copy->view};
      event.tuple.key = copy->key;
      event.tuple.value = copy->value;
      event.tuple.media_type = copy->media;
      if (still->who == self) {
        still->call(event);
      } else {
        link.publish(still->who, std::span(&event, 1));
      }
    });
  }

  void announce(EventKind kind, const Tuple& t) {
    for (const auto& [id, s] : local) {
      if (s->pattern.matches(t.view.owner, t.view.key)) tell(s, kind, t);
    }
    if (t.view.owner != self) return;
    std::set<OwnerId> told;
    for (const auto& [id, s] : distant) {
      if (s->pattern.matches(t.view.owner, t.view.key) && told.insert(s->who).second) tell(s, kind, t);
    }
  }

  void check_demand() {
    if (demand_posted) return;
    demand_posted = true;
    later([this] {
      demand_posted = false;
      for (const auto& watch : std::vector(watches)) {
        std::map<std::string, std::pair<bool, Duration>> now;
        for (const auto& [name, t] : tuples) {
          if (name.first == self && watch->pattern.matches(self, name.second))
            now[name.second] = demand_of(name.second);
        }
        auto last = std::exchange(watch->last, now);
        for (const auto& [key, d] : now) {
          const auto before = last.contains(key) ? last[key] : std::pair(false, Duration(0));
          if (before == d || !tuples.contains({self, key})) continue;
          watch->call(Demand{tuples.at({self, key}).ref, key, d.first, d.second});
        }
      }
    });
  }

  std::pair<bool, Duration> demand_of(const std::string& key) const {
    bool wanted = false;
    Duration shortest = Duration::max();
    auto look = [&](const Subscription& s) {
      if (s.flow.passive || !s.pattern.matches(self, key)) return;
      wanted = true;
      shortest = std::min(shortest, s.flow.minimum);
    };
    for (const auto& [id, s] : local) look(*s);
    for (const auto& [id, s] : distant) look(*s);
    return {wanted, wanted ? shortest : Duration(0)};
  }

  Tuple& store(OwnerId owner, std::string_view key, std::string_view value, const SetOptions& options,
               OwnerId creator) {
    auto [found, fresh] = tuples.try_emplace(Name(owner, key));
    auto& t = found->second;
    if (fresh) {
      t.ref = {next_index++, 1};
      own_by_index[t.ref.index] = key;
      t.view.owner = owner;
      t.view.key = found->first.second;
      check_demand();
    }
    t.value = value;
    t.media_type = options.media_type;
    t.view.value = t.value;
    t.view.media_type = t.media_type;
    t.view.creator = creator;
    ++t.view.sequence;
    t.view.write_time = scheduler.wall_now();
    t.view.user_time = options.user_time;
    t.view.expire_time =
        options.lifetime > Duration(0)
            ? t.view.write_time + std::chrono::duration_cast<std::chrono::microseconds>(options.lifetime)
            : WallTime{};
    if (owner == self) arm_expiry(std::string(key), options.lifetime);
    ++sets;
    announce(EventKind::kSet, t);
    return t;
  }

  void arm_expiry(const std::string& key, Duration lifetime) {
    expiry.erase(key);
    if (lifetime <= Duration(0)) return;
    expiry[key] = scheduler.after(lifetime, [this, key] { remove({self, key}, EventKind::kExpired); });
  }

  void remove(Name name, EventKind kind) {
    const auto found = tuples.find(name);
    if (found == tuples.end()) return;
    announce(kind, found->second);
    own_by_index.erase(found->second.ref.index);
    tuples.erase(found);
    check_demand();
  }

  Judgement decide(const RemoteSet& wish) {
    std::shared_ptr<Judge> best;
    std::size_t length = 0;
    for (const auto& [pattern, judge] : judges) {
      if (!pattern.matches(self, wish.key)) continue;
      const std::size_t score = pattern.exact() ? 100000 : pattern.key.size();
      if (!best || score > length) {
        best = judge;
        length = score;
      }
    }
    if (best) return (*best)(wish);
    if (!tuples.contains({self, wish.key})) {
      return Judgement::refused({ErrorCode::kNotFound, fmt::format("no tuple {}", wish.key)});
    }
    return Judgement::refused({ErrorCode::kRefused, fmt::format("{} is read-only", wish.key)});
  }

  Reply answer(const RemoteSet& wish) {
    const auto judgement = decide(wish);
    if (judgement.verdict == Verdict::kApplied && judgement.store) {
      store(self, wish.key, wish.value, {wish.media_type, wish.user_time, wish.lifetime}, wish.from);
    }
    return {wish.from, wish.request, judgement.verdict, judgement.code, judgement.text};
  }

  void take_reply(const Reply& reply) {
    auto node = requests.extract(reply.request);
    if (node && node.mapped().call) node.mapped().call(reply);
  }
};

TupleSpace::TupleSpace(OwnerId self, Scheduler& scheduler, Link& link)
    : parts_(std::make_unique<Parts>(self, scheduler, link)) {
  link.attach(this);
}
TupleSpace::~TupleSpace() {
  parts_->link.attach(nullptr);
}
OwnerId TupleSpace::self() const {
  return parts_->self;
}

Result<TupleRef> TupleSpace::declare(std::string_view key, std::string_view value, const SetOptions& options) {
  if (const auto there = find(key)) return *there;
  return set(key, value, options);
}

Result<TupleRef> TupleSpace::set(std::string_view key, std::string_view value, const SetOptions& options) {
  if (auto ok = model::check_key(key); !ok) return fail(ok.error());
  return parts_->store(parts_->self, key, value, options, parts_->self).ref;
}

Result<void> TupleSpace::set(TupleRef tuple, std::string_view value, const SetOptions& options) {
  const auto found = parts_->own_by_index.find(tuple.index);
  if (found == parts_->own_by_index.end()) return fail(ErrorCode::kNotFound, "the tuple is gone");
  parts_->store(parts_->self, found->second, value, options, parts_->self);
  return {};
}

Result<void> TupleSpace::erase(std::string_view key) {
  if (!find(key)) return fail(ErrorCode::kNotFound, fmt::format("no tuple {}", model::quoted(key)));
  parts_->remove({parts_->self, std::string(key)}, EventKind::kDeleted);
  return {};
}

void TupleSpace::erase(const Pattern& pattern) {
  std::vector<std::string> keys;
  for (const auto& [name, t] : parts_->tuples) {
    if (name.first == parts_->self && pattern.matches(name.first, name.second)) keys.push_back(name.second);
  }
  for (const auto& key : keys) parts_->remove({parts_->self, key}, EventKind::kDeleted);
}

std::optional<TupleRef> TupleSpace::find(std::string_view key) const {
  const auto found = parts_->tuples.find({parts_->self, std::string(key)});
  if (found == parts_->tuples.end()) return std::nullopt;
  return found->second.ref;
}

bool TupleSpace::has_subscriber(TupleRef tuple) const {
  const auto found = parts_->own_by_index.find(tuple.index);
  if (found == parts_->own_by_index.end()) return false;
  auto any = [&](const auto& map) {
    return std::any_of(map.begin(), map.end(),
                       [&](const auto& e) { return e.second->pattern.matches(parts_->self, found->second); });
  };
  return any(parts_->local) || any(parts_->distant);
}

Handle TupleSpace::watch_demand(const Pattern& pattern, DemandCall call) {
  auto watch = std::make_shared<Parts::Watch>(Parts::Watch{pattern, std::move(call), {}});
  parts_->watches.push_back(watch);
  parts_->check_demand();
  return Handle([parts = parts_.get(), live = std::weak_ptr<bool>(parts_->alive), watch] {
    if (live.lock()) std::erase(parts->watches, watch);
  });
}

Handle TupleSpace::judge(const Pattern& pattern, Judge judge) {
  auto shared = std::make_shared<Judge>(std::move(judge));
  parts_->judges.emplace_back(pattern, shared);
  return Handle([parts = parts_.get(), live = std::weak_ptr<bool>(parts_->alive), shared] {
    if (live.lock()) std::erase_if(parts->judges, [&](const auto& j) { return j.second == shared; });
  });
}

Handle TupleSpace::subscribe(const Pattern& pattern, const Flow& flow, EventCall call) {
  const auto id = parts_->next_id++;
  auto s = std::make_shared<Parts::Subscription>(Parts::Subscription{parts_->self, id, pattern, flow, std::move(call)});
  parts_->local[id] = s;
  for (const auto& [name, t] : parts_->tuples) {
    if (pattern.matches(name.first, name.second)) parts_->tell(s, EventKind::kSet, t);
  }
  parts_->link.subscribe({id, pattern, flow});
  parts_->check_demand();
  return Handle([parts = parts_.get(), live = std::weak_ptr<bool>(parts_->alive), id] {
    if (!live.lock()) return;
    parts->local.erase(id);
    parts->link.unsubscribe(id);
    parts->check_demand();
  });
}

std::uint64_t TupleSpace::set_remote(OwnerId owner, std::string_view key, std::string_view value, Duration time_to_live,
                                     ReplyCall call, const SetOptions& options) {
  const bool given = time_to_live > Duration(0);
  if (!given) time_to_live = std::chrono::seconds(5);
  const auto request = parts_->next_request++;
  RemoteSet wish{parts_->self,
                 owner,
                 request,
                 std::string(key),
                 std::string(value),
                 std::string(options.media_type),
                 options.user_time,
                 options.lifetime,
                 time_to_live,
                 given};
  auto* parts = parts_.get();
  auto timer = parts->scheduler.after(time_to_live, [parts, request] {
    parts->take_reply({parts->self, request, Verdict::kExpired, ErrorCode::kExpired, "no answer in time"});
  });
  parts->requests[request] = {std::move(call), std::move(timer)};
  if (owner == parts->self) {
    parts->later([parts, wish] { parts->take_reply(parts->answer(wish)); });
  } else if (auto sent = parts->link.remote_set(wish); !sent) {
    parts->later([parts, request, error = sent.error()] {
      parts->take_reply({parts->self, request, Verdict::kNoSuchOwner, error.code, error.text});
    });
  }
  return request;
}

std::optional<TupleView> TupleSpace::get(OwnerId owner, std::string_view key) const {
  const auto found = parts_->tuples.find({owner, std::string(key)});
  if (found == parts_->tuples.end()) return std::nullopt;
  return found->second.view;
}

void TupleSpace::list(const Pattern& pattern, const std::function<void(const TupleView&)>& visit) const {
  for (const auto& [name, t] : parts_->tuples) {
    if (pattern.matches(name.first, name.second)) visit(t.view);
  }
}

std::vector<OwnerId> TupleSpace::peers() const {
  return parts_->link.peers();
}

Handle TupleSpace::watch_peers(PeerCall call) {
  auto shared = std::make_shared<PeerCall>(std::move(call));
  parts_->peer_calls.push_back(shared);
  return Handle([parts = parts_.get(), live = std::weak_ptr<bool>(parts_->alive), shared] {
    if (live.lock()) std::erase(parts->peer_calls, shared);
  });
}

TupleSpace::Stats TupleSpace::stats() const {
  Stats stats;
  for (const auto& [name, t] : parts_->tuples) ++(name.first == parts_->self ? stats.own : stats.cached);
  stats.subscriptions = parts_->local.size();
  stats.sets = parts_->sets;
  stats.events = parts_->events;
  return stats;
}

void TupleSpace::on_changes(OwnerId owner, std::span<const Change> changes) {
  for (const auto& change : changes) {
    Parts::Name name(owner, change.tuple.key);
    if (change.kind != EventKind::kSet) {
      parts_->remove(name, change.kind);
      continue;
    }
    auto found = parts_->tuples.find(name);
    if (found != parts_->tuples.end() && found->second.view.sequence >= change.tuple.sequence) continue;
    auto& t = found != parts_->tuples.end() ? found->second : parts_->tuples[name];
    t.value = change.tuple.value;
    t.media_type = change.tuple.media_type;
    t.view = change.tuple;
    t.view.key = parts_->tuples.find(name)->first.second;
    t.view.value = t.value;
    t.view.media_type = t.media_type;
    parts_->announce(EventKind::kSet, t);
  }
}

void TupleSpace::on_subscribe(OwnerId subscriber, const SubscriptionSpec& spec) {
  auto s = std::make_shared<Parts::Subscription>(Parts::Subscription{subscriber, spec.id, spec.pattern, spec.flow, {}});
  parts_->distant[{subscriber, spec.id}] = s;
  for (const auto& [name, t] : parts_->tuples) {
    if (name.first == parts_->self && spec.pattern.matches(name.first, name.second)) {
      parts_->tell(s, EventKind::kSet, t);
    }
  }
  parts_->check_demand();
}

void TupleSpace::on_unsubscribe(OwnerId subscriber, std::uint32_t id) {
  parts_->distant.erase({subscriber, id});
  parts_->check_demand();
}

void TupleSpace::on_remote_set(const RemoteSet& wish) {
  parts_->link.reply(parts_->answer(wish));
}
void TupleSpace::on_reply(const Reply& reply) {
  parts_->take_reply(reply);
}

void TupleSpace::on_peer(OwnerId peer, PeerEvent event) {
  if (event != PeerEvent::kUp) {
    std::erase_if(parts_->distant, [&](const auto& e) { return e.first.first == peer; });
    parts_->check_demand();
  }
  for (const auto& call : std::vector(parts_->peer_calls)) (*call)(peer, event);
}

}  // namespace rubicon::tuples
