#include "web/api/feed.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/text.h"
#include "model/json_members.h"
#include "verbs/answers.h"
#include "web/api/forms.h"

namespace rubicon::web::api {

std::string SocketWriter::update(const TupleView& tuple) const {
  std::string text;
  append_update(tuple, full_, text);
  return text;
}

void SocketWriter::presence(const std::vector<OwnerId>& owners, bool absent) {
  std::string ids;
  for (const auto owner : owners) base::append(ids, "{}{}", ids.empty() ? "" : ",", number(owner));
  base::append(head_, ",\"{}\":[{}]", absent ? "absent" : "present", ids);
}

void SocketWriter::set(OwnerId owner, std::string_view key, std::uint32_t number, bool introduce,
                       std::string_view update) {
  if (introduce) {
    base::append(keys_, "{}\"{}\":\"{}:{}\"", keys_.empty() ? "" : ",", number, model::number(owner), key);
  }
  base::append(sets_, "{}[{},{}]", sets_.empty() ? "" : ",", number, update);
}

void SocketWriter::gone(OwnerId, std::string_view, std::uint32_t number, EventKind how) {
  base::append(gone_, "{}[{},\"{}\"]", gone_.empty() ? "" : ",", number, to_string(how));
}

void SocketWriter::snapshot(OwnerId owner) {
  base::append(tail_, ",\"snapshot\":{}", number(owner));
}

std::string SocketWriter::finish() {
  if (size() + tail_.size() == 0) return {};
  auto text = fmt::format("{{\"s\":{}{}", subscription_, std::exchange(head_, {}));
  const auto put = [&text](std::string_view name, char open, std::string&& content, char close) {
    if (!content.empty()) base::append(text, ",\"{}\":{}{}{}", name, open, content, close);
    content.clear();
  };
  put("k", '{', std::move(keys_), '}');
  put("set", '[', std::move(sets_), ']');
  put("gone", '[', std::move(gone_), ']');
  text += std::exchange(tail_, {});
  return text + '}';
}

std::string SocketWriter::lost(std::uint64_t events) {
  return fmt::format(R"({{"lost":{{"s":{},"events":{}}}}})", subscription_, events);
}

std::string StreamWriter::update(const TupleView& tuple) const {
  if (tuple.value.size() <= kMaxSentValue) return model::dump(verbs::tuple_json(tuple));
  auto short_tuple = tuple;
  short_tuple.value = {};
  auto tree = verbs::tuple_json(short_tuple);
  tree["value"] = nullptr;
  tree["size"] = tuple.value.size();
  return model::dump(tree);
}

void StreamWriter::add(std::string_view event, std::string_view data) {
  base::append(text_, "event: {}\nid: {}\ndata: {}\n\n", event, ++events_, data);
}

void StreamWriter::presence(const std::vector<OwnerId>& owners, bool absent) {
  for (const auto owner : owners) add(absent ? "absent" : "present", fmt::format("{{\"owner\":{}}}", number(owner)));
}

void StreamWriter::set(OwnerId, std::string_view, std::uint32_t, bool, std::string_view update) {
  add("set", update);
}

void StreamWriter::gone(OwnerId owner, std::string_view key, std::uint32_t, EventKind how) {
  add(to_string(how), fmt::format("{{\"owner\":{},\"key\":\"{}\"}}", number(owner), key));
}

void StreamWriter::snapshot(OwnerId owner) {
  add("snapshot", fmt::format("{{\"owner\":{}}}", number(owner)));
}

std::string StreamWriter::finish() {
  return std::exchange(text_, {});
}

std::string StreamWriter::lost(std::uint64_t events) {
  add("lost", fmt::format("{{\"events\":{}}}", events));
  return finish();
}

Feed::Feed(Context& context, Caller caller, EventStock& stock, verbs::Subscription options,
           std::unique_ptr<FeedWriter> writer, Callbacks calls)
    : context_(context),
      caller_(std::move(caller)),
      judged_(!context.permission.sees_all(caller_)),
      stock_(stock),
      options_(std::move(options)),
      writer_(std::move(writer)),
      callbacks_(std::move(calls)),
      pause_(context.scheduler, [this] { callbacks_.wake(); }) {
  ++context_.counters.subscriptions;
  auto& space = context_.space;
  // Without a minimum interval, which would merge events; next() keeps the pace of states.
  data_ = space.subscribe(
      options_.pattern, {{}, options_.maximum, options_.dead_band, true},
      [this](const tuples::Event& event) { changed(event); }, [this](OwnerId owner) { snapshot_ended(owner); });
  if (options_.active && !judged_)
    demand_ = space.subscribe(options_.pattern, wanted(Duration(0)), [](const tuples::Event&) {});
  peers_ = space.watch_peers([this](OwnerId peer, tuples::PeerEvent event) { peer_changed(peer, event); });
}

Feed::~Feed() {
  for (const auto& item : events_) leave_stock(item);
  while (!entries_.empty()) forget(entries_.begin());
  stock_.hidden -= hidden_.size();
  --context_.counters.subscriptions;
}

void Feed::leave_stock(const Item& item) {
  --stock_.events;
  stock_.bytes -= item.event.size();
}

/// What creates demand; rights may allow slower demand only.
Flow Feed::wanted(Duration fastest) const {
  return {std::max(options_.minimum.value_or(kUsualMinimum), fastest), options_.maximum, options_.dead_band, false};
}

tuples::Access Feed::access(const TupleView& tuple) {
  const NameView name{tuple.owner, tuple.key};
  if (!judged_) return {};
  if (hidden_.contains(name)) return {false, false, {}};
  const auto given = context_.permission.access(caller_, tuple.key);
  if (!given.read && stock_.hidden < EventStock::kMaxHidden) {
    ++stock_.hidden;
    hidden_.insert({tuple.owner, std::string(tuple.key)});
  }
  return given;
}

void Feed::want(Node& node, const tuples::Access& access) {
  if (!judged_ || !options_.active || !access.demand) return;
  if (stock_.demands >= EventStock::kMaxDemands) return report_full(kTooManyDemands);
  auto& demand = node.second.demand;
  demand = context_.demands.of(node.first.owner, node.first.key, wanted(access.interval));
  if (!demand) return report_full(kTooManySharedDemands);
  ++stock_.demands;
}

void Feed::report_full(const char* why) {
  if (!std::exchange(stock_.full, true)) callbacks_.full(why);
}

void Feed::forget(Entries::iterator entry) {
  const auto owner = owners_.find(entry->first.owner);
  if (entry->second.demand) --stock_.demands;
  --stock_.tuples;
  entries_.erase(entry);
  --owner->second.tuples;
  forget_if_gone(owner);
}

/// Without this, a page that stays open would keep an entry for each component that ever came.
void Feed::forget_if_gone(Owners::iterator owner) {
  if (owner->second.absent && owner->second.tuples == 0) owners_.erase(owner);
}

void Feed::forget_hidden(const TupleView& tuple) {
  const auto found = hidden_.find(NameView{tuple.owner, tuple.key});
  if (found == hidden_.end()) return;
  hidden_.erase(found);
  --stock_.hidden;
}

/// One that left between its tuples and the end of its snapshot is not there any more.
Feed::Owners::iterator Feed::owner_at(OwnerId owner) {
  const auto [found, fresh] = owners_.try_emplace(owner);
  if (!fresh || owner == context_.space.self()) return found;
  const auto peers = context_.space.peers();
  found->second.absent = std::find(peers.begin(), peers.end(), owner) == peers.end();
  return found;
}

/// nullptr: there is no room, or the caller may not read it.
Feed::Node* Feed::node_of(const TupleView& tuple) {
  const auto known = entries_.find(NameView{tuple.owner, tuple.key});
  if (known != entries_.end()) return &*known;
  const auto given = access(tuple);
  if (!given.read) return nullptr;
  if (stock_.tuples >= EventStock::kMaxTuples) {
    report_full(kTooManyTuples);
    return nullptr;
  }
  ++stock_.tuples;
  auto& node = *entries_.emplace(Name{tuple.owner, std::string(tuple.key)}, Entry{}).first;
  want(node, given);
  ++owner_at(tuple.owner)->second.tuples;
  return &node;
}

/// The tuples are there; the events of some may still be queued.
void Feed::snapshot_ended(OwnerId owner) {
  context_.space.list({owner, options_.pattern.key}, [this](const TupleView& tuple) { set(tuple); });
  forget_if_gone(owner_at(owner));
  ++snapshots_;
  push(items_, {nullptr, owner});
}

void Feed::changed(const tuples::Event& event) {
  if (event.kind == EventKind::kSet) return set(event.tuple);
  const auto known = entries_.find(NameView{event.tuple.owner, event.tuple.key});
  if (known == entries_.end()) return forget_hidden(event.tuple);
  ended(*known, event.kind);
}

void Feed::set(const TupleView& tuple) {
  auto* known = node_of(tuple);
  if (known == nullptr) return;
  auto& node = *known;
  auto& entry = node.second;
  entry.gone.reset();
  const bool is_heartbeat = entry.sequence == tuple.sequence && entry.written == tuple.write_time;
  if (is_heartbeat && options_.maximum == Duration(0)) return;
  entry.sequence = tuple.sequence;
  entry.written = tuple.write_time;
  if (entry.sets == Sets::kUnknown) entry.sets = context_.event_types.sets_of(tuple.owner, tuple.key);
  if (entry.sets == Sets::kEvents) return keep_event(node, tuple);
  if (entry.waits) return callbacks_.merged();
  entry.waits = true;
  push(items_, {&node, tuple.owner});
}

void Feed::ended(Node& node, EventKind kind) {
  node.second.gone = kind;
  if (node.second.items == 0) push(items_, {&node, node.first.owner});
}

/// The first event is what was there before; it takes no room in the stock, so that a snapshot loses nothing. That an
/// event is over (its value is empty then) is not an event.
void Feed::keep_event(Node& node, const TupleView& tuple) {
  if (tuple.value.empty() && (node.second.introduced || node.second.items > 0)) return;
  Item item{&node, tuple.owner, writer_->update(tuple)};
  if (!node.second.introduced && node.second.items == 0) return push(items_, std::move(item));
  if (!stock_.has_room(item.event.size()) && !drop_oldest_event()) {
    note_lost();
    return;
  }
  ++stock_.events;
  stock_.bytes += item.event.size();
  push(events_, std::move(item));
}

void Feed::note_lost() {
  ++lost_events_;
  ++context_.counters.lost_events;
}

/// Keeps the newest events of this subscription. False: it has none that could go.
bool Feed::drop_oldest_event() {
  if (events_.empty()) return false;
  auto& node = *pop(events_).tuple;
  if (node.second.gone && node.second.items == 0) push(items_, {&node, node.first.owner});
  note_lost();
  return true;
}

void Feed::peer_changed(OwnerId owner, tuples::PeerEvent event) {
  const auto known = owners_.find(owner);
  const bool absent = event != tuples::PeerEvent::kUp;
  if (known == owners_.end() && !absent) presence_.erase(owner);  // it was forgotten, and the client not told yet
  if (known == owners_.end() || known->second.absent == absent) return;
  known->second.absent = absent;
  presence_[owner] = absent;
  forget_if_gone(known);
  wake();
}

void Feed::push(std::deque<Item>& queue, Item item) {
  if (item.tuple != nullptr) ++item.tuple->second.items;
  queue.push_back(std::move(item));
  wake();
}

Feed::Item Feed::pop(std::deque<Item>& queue) {
  auto item = std::move(queue.front());
  queue.pop_front();
  if (item.tuple != nullptr) --item.tuple->second.items;
  if (&queue == &events_) leave_stock(item);
  return item;
}

bool Feed::due() const {
  if (!has_items() && presence_.empty() && lost_events_ == 0) return false;
  return snapshots_ > 0 || !presence_.empty() || context_.scheduler.now() >= not_before_;
}

void Feed::wake() {
  if (due()) return callbacks_.wake();
  if (!pause_.is_set()) pause_.set_at(not_before_);
}

std::optional<std::string> Feed::next() {
  if (!due()) return std::nullopt;
  if (lost_events_ > 0) return writer_->lost(std::exchange(lost_events_, 0));
  fill();
  not_before_ = context_.scheduler.now() + options_.minimum.value_or(kUsualMinimum);
  if (has_items()) wake();
  free_numbers_.insert(free_numbers_.end(), freed_numbers_.begin(), freed_numbers_.end());
  freed_numbers_.clear();
  auto frame = writer_->finish();
  if (frame.empty()) return std::nullopt;
  return frame;
}

/// Events come first, unless the client does not know the tuple yet: then the first event is among the items.
void Feed::fill() {
  frame_closed_ = false;
  const auto room = [this] { return !frame_closed_ && writer_->size() < kMaxFrame; };
  add_presence();
  while (!events_.empty() && events_.front().tuple->second.introduced && room()) add(pop(events_));
  while (!items_.empty() && room()) add(pop(items_));
  while (!events_.empty() && items_.empty() && room()) add(pop(events_));
}

void Feed::add_presence() {
  for (const bool absent : {true, false}) {
    std::vector<OwnerId> owners;
    for (const auto& [owner, is_absent] : presence_) {
      if (is_absent == absent) owners.push_back(owner);
    }
    if (!owners.empty()) writer_->presence(owners, absent);
  }
  presence_.clear();
}

void Feed::add(const Item& item) {
  if (item.tuple == nullptr) {
    --snapshots_;
    writer_->snapshot(item.owner);
    frame_closed_ = true;
    return;
  }
  auto& node = *item.tuple;
  if (!item.event.empty()) {
    add_update(node, item.event);
  } else if (std::exchange(node.second.waits, false) && !node.second.gone) {
    const auto tuple = context_.space.get(node.first.owner, node.first.key);
    if (tuple) add_update(node, writer_->update(*tuple));
  }
  if (node.second.gone && node.second.items == 0) add_gone(node);
}

void Feed::add_update(Node& node, std::string_view update) {
  auto& entry = node.second;
  const bool introduce = !std::exchange(entry.introduced, true);
  if (introduce) {
    if (free_numbers_.empty()) free_numbers_.push_back(next_number_++);
    entry.number = free_numbers_.back();
    free_numbers_.pop_back();
  }
  writer_->set(node.first.owner, node.first.key, entry.number, introduce, update);
}

void Feed::add_gone(Node& node) {
  const auto& entry = node.second;
  if (entry.introduced) {
    writer_->gone(node.first.owner, node.first.key, entry.number, *entry.gone);
    freed_numbers_.push_back(entry.number);
  }
  forget(entries_.find(node.first));
}

}  // namespace rubicon::web::api
