#include "web/api/feed.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "model/json_members.h"
#include "web/api/tuple_forms.h"

namespace rubicon::web::api {

/// The parts of a frame under construction.
struct Feed::Frame {
  std::string head, keys, sets, gone, tail;
  std::vector<std::uint32_t> freed;  ///< numbers that end with this frame
  bool closed = false;               ///< nothing may follow

  std::size_t size() const { return head.size() + keys.size() + sets.size() + gone.size(); }
};

Feed::Feed(Scheduler& scheduler, TupleSpace& space, EventTypes& types, EventStock& stock, unsigned number,
           FeedOptions options, Calls calls)
    : scheduler_(scheduler),
      space_(space),
      types_(types),
      stock_(stock),
      number_(number),
      options_(std::move(options)),
      calls_(std::move(calls)),
      pause_(scheduler, [this] { calls_.wake(); }) {
  // Without a minimum interval, which would merge events; next() keeps the pace of states.
  data_ = space_.subscribe(
      options_.pattern, {{}, options_.maximum, options_.dead_band, true},
      [this](const tuples::Event& event) { changed(event); }, [this](OwnerId owner) { snapshot_ended(owner); });
  if (options_.active) {
    const Flow wanted{options_.minimum, options_.maximum, options_.dead_band, false};
    demand_ = space_.subscribe(options_.pattern, wanted, [](const tuples::Event&) {});
  }
  peers_ = space_.watch_peers([this](OwnerId peer, tuples::PeerEvent event) { peer_changed(peer, event); });
}

Feed::~Feed() {
  for (const auto& item : events_) leave_stock(item);
}

void Feed::leave_stock(const Item& item) {
  --stock_.events;
  stock_.bytes -= item.event.size();
}

Feed::Node& Feed::node_of(const TupleView& tuple) {
  if (const auto known = entries_.find(NameView{tuple.owner, tuple.key}); known != entries_.end()) return *known;
  auto& node = *entries_.emplace(Name{tuple.owner, std::string(tuple.key)}, Entry{}).first;
  owners_.emplace(tuple.owner, false);
  return node;
}

/// The tuples are there; the events of some may still be queued.
void Feed::snapshot_ended(OwnerId owner) {
  owners_.emplace(owner, false);
  space_.list({owner, options_.pattern.key}, [this](const TupleView& tuple) { set(tuple); });
  ++snapshots_;
  push(items_, {nullptr, owner});
}

void Feed::changed(const tuples::Event& event) {
  if (event.kind == EventKind::kSet) return set(event.tuple);
  const auto known = entries_.find(NameView{event.tuple.owner, event.tuple.key});
  if (known != entries_.end()) ended(*known, event.kind);
}

void Feed::set(const TupleView& tuple) {
  auto& node = node_of(tuple);
  auto& entry = node.second;
  entry.gone.reset();
  const bool is_heartbeat = entry.sequence == tuple.sequence && entry.written == tuple.write_time;
  if (is_heartbeat && options_.maximum == Duration(0)) return;
  entry.sequence = tuple.sequence;
  entry.written = tuple.write_time;
  entry.is_event = entry.is_event || types_.holds_events(tuple.owner, tuple.key);
  if (entry.is_event) return keep_event(node, tuple);
  if (entry.waits) return calls_.merged();
  entry.waits = true;
  push(items_, {&node, tuple.owner});
}

void Feed::ended(Node& node, EventKind kind) {
  node.second.gone = kind;
  if (node.second.items == 0) push(items_, {&node, node.first.owner});
}

/// The first event is what was there before; it takes no room in the stock, so that a snapshot loses nothing.
void Feed::keep_event(Node& node, const TupleView& tuple) {
  Item item{&node, tuple.owner};
  append_update(tuple, options_.full, item.event);
  if (!node.second.introduced && node.second.items == 0) return push(items_, std::move(item));
  if (!stock_.has_room(item.event.size()) && !drop_oldest_event()) {
    ++lost_events_;
    return;
  }
  ++stock_.events;
  stock_.bytes += item.event.size();
  push(events_, std::move(item));
}

/// Keeps the newest events of this subscription. False: it has none that could go.
bool Feed::drop_oldest_event() {
  if (events_.empty()) return false;
  auto& node = *pop(events_).tuple;
  if (node.second.gone && node.second.items == 0) push(items_, {&node, node.first.owner});
  ++lost_events_;
  return true;
}

void Feed::peer_changed(OwnerId owner, tuples::PeerEvent event) {
  const auto known = owners_.find(owner);
  const bool absent = event != tuples::PeerEvent::kUp;
  if (known == owners_.end() || known->second == absent) return;
  known->second = absent;
  presence_[owner] = absent;
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
  return snapshots_ > 0 || !presence_.empty() || scheduler_.now() >= not_before_;
}

void Feed::wake() {
  if (due()) return calls_.wake();
  if (!pause_.is_set()) pause_.set_at(not_before_);
}

std::optional<std::string> Feed::next() {
  if (!due()) return std::nullopt;
  if (lost_events_ > 0) {
    const auto lost = std::exchange(lost_events_, 0);
    return fmt::format(R"({{"lost":{{"s":{},"events":{}}}}})", number_, lost);
  }
  Frame frame;
  fmt::format_to(std::back_inserter(frame.head), "{{\"s\":{}", number_);
  bool any = add_head(frame);
  const auto room = [&] { return !frame.closed && frame.size() < kMaxFrame; };
  while (!events_.empty() && events_.front().tuple->second.introduced && room()) add(frame, pop(events_));
  while (!items_.empty() && room()) add(frame, pop(items_));
  while (!events_.empty() && items_.empty() && room()) add(frame, pop(events_));
  any = any || frame.closed || !frame.sets.empty() || !frame.gone.empty();
  not_before_ = scheduler_.now() + options_.minimum;
  if (has_items()) wake();
  if (!any) return std::nullopt;
  return finish(frame);
}

/// Owners that left and returned. False: there are none.
bool Feed::add_head(Frame& frame) {
  const auto any = !presence_.empty();
  for (const bool absent : {true, false}) {
    std::string ids;
    for (const auto& [owner, is_absent] : presence_) {
      if (is_absent == absent) fmt::format_to(std::back_inserter(ids), "{}{}", ids.empty() ? "" : ",", number(owner));
    }
    if (ids.empty()) continue;
    fmt::format_to(std::back_inserter(frame.head), ",\"{}\":[{}]", absent ? "absent" : "present", ids);
  }
  presence_.clear();
  return any;
}

void Feed::add(Frame& frame, const Item& item) {
  if (item.tuple == nullptr) {
    --snapshots_;
    fmt::format_to(std::back_inserter(frame.tail), ",\"snapshot\":{}", number(item.owner));
    frame.closed = true;
    return;
  }
  auto& node = *item.tuple;
  if (!item.event.empty()) {
    add_update(frame, node, item.event);
  } else if (std::exchange(node.second.waits, false) && !node.second.gone) {
    std::string update;
    const auto tuple = space_.get(node.first.owner, node.first.key);
    if (tuple) append_update(*tuple, options_.full, update);
    if (tuple) add_update(frame, node, update);
  }
  if (node.second.gone && node.second.items == 0) add_gone(frame, node);
}

void Feed::add_update(Frame& frame, Node& node, std::string_view update) {
  auto& entry = node.second;
  if (!std::exchange(entry.introduced, true)) {
    if (free_numbers_.empty()) free_numbers_.push_back(next_number_++);
    entry.number = free_numbers_.back();
    free_numbers_.pop_back();
    fmt::format_to(std::back_inserter(frame.keys), "{}\"{}\":\"{}:{}\"", frame.keys.empty() ? "" : ",", entry.number,
                   number(node.first.owner), node.first.key);
  }
  fmt::format_to(std::back_inserter(frame.sets), "{}[{},{}]", frame.sets.empty() ? "" : ",", entry.number, update);
}

void Feed::add_gone(Frame& frame, Node& node) {
  const auto& entry = node.second;
  if (entry.introduced) {
    fmt::format_to(std::back_inserter(frame.gone), "{}[{},\"{}\"]", frame.gone.empty() ? "" : ",", entry.number,
                   to_string(*entry.gone));
    frame.freed.push_back(entry.number);
  }
  entries_.erase(node.first);
}

std::string Feed::finish(Frame& frame) {
  auto text = std::move(frame.head);
  const auto put = [&text](std::string_view name, char open, std::string_view content, char close) {
    if (!content.empty()) fmt::format_to(std::back_inserter(text), ",\"{}\":{}{}{}", name, open, content, close);
  };
  put("k", '{', frame.keys, '}');
  put("set", '[', frame.sets, ']');
  put("gone", '[', frame.gone, ']');
  text += frame.tail;
  text += '}';
  free_numbers_.insert(free_numbers_.end(), frame.freed.begin(), frame.freed.end());
  return text;
}

}  // namespace rubicon::web::api
