#include "tuples/mqtt/search.h"

#include <algorithm>
#include <utility>

namespace rubicon::tuples::mqtt {

Search::Search(const Topics& topics, Scheduler& scheduler, Callbacks calls)
    : topics_(topics), callbacks_(std::move(calls)), late_(scheduler, [this] {
        callbacks_.late();
        fence();
      }) {}

/// The own inbox is the first step, so that messages to this process arrive while it reads.
void Search::connected() {
  connected_ = true;
  for (auto& [line, read] : lines_) {
    if (std::exchange(read, false)) ++unread_[line.user];
  }
  queue_.push_back({{}, {}, {}, true});
  add_all();
  next();
}

void Search::cut() {
  connected_ = ready_ = all_read_ = false;
  for (auto& [id, sought] : components_) sought.read = false;
  step_.clear();
  queue_.clear();
  late_.clear();
}

void Search::read_again() {
  if (!ready_ || !idle()) return;
  add_all();
  next();
}

void Search::add_all() {
  if (all_) {
    for (const auto shard : Topics::kShards) queue_.push_back({topics_.presence_filter(shard), {}, {}, true});
  } else {
    for (const auto& [id, sought] : components_) queue_.push_back({topics_.component_filter(id), id});
    for (const auto& [line, read] : lines_) queue_.push_back({topics_.line_filter(line), {}, line});
  }
  Part end;
  end.ends = true;
  end.ends_all = all_;
  queue_.push_back(end);
}

void Search::next() {
  while (connected_ && step_.empty() && !queue_.empty()) {
    if (queue_.front().ends) {
      const bool all = queue_.front().ends_all;
      if (all) narrow();
      queue_.pop_front();
      ready_ = true;
      callbacks_.complete(all);
      continue;
    }
    do {
      step_.push_back(std::move(queue_.front()));
      queue_.pop_front();
    } while (!step_.back().alone && step_.size() < kMaxParts && !queue_.empty() && !queue_.front().alone &&
             !queue_.front().ends);
    ++number_;
    for (const auto& part : step_) {
      if (!part.filter.empty()) callbacks_.subscribe(part.filter);
    }
    fence();
  }
}

void Search::fence() {
  callbacks_.fence(number_);
  late_.set(kFenceTime);
}

void Search::passed(std::uint64_t step) {
  if (step != number_ || step_.empty()) return;
  late_.clear();
  const auto done = std::exchange(step_, {});
  for (const auto& part : done) {
    if (const auto found = part.component ? components_.find(*part.component) : components_.end();
        found != components_.end())
      found->second.read = true;
    if (part.line) read(*part.line);
  }
  next();
}

void Search::read(const Line& line) {
  const auto found = lines_.find(line);
  if (found == lines_.end()) return;  // forgotten meanwhile
  if (!std::exchange(found->second, true)) count_read(line);
  callbacks_.line_read(line);
}

/// All presence was read: it includes the components that were searched for one by one.
void Search::narrow() {
  all_read_ = true;
  for (const auto& [id, sought] : components_) callbacks_.unsubscribe(topics_.component_filter(id));
  for (const auto& [line, read] : lines_) callbacks_.unsubscribe(topics_.line_filter(line));
  components_.clear();
  lines_.clear();
  unread_.clear();
}

void Search::all() {
  if (std::exchange(all_, true) || !connected_) return;
  add_all();
  next();
}

void Search::component(OwnerId id) {
  if (all_ || components_.contains(id)) return;
  if (components_.size() >= kMaxSought) make_room();
  if (components_.size() >= kMaxSought) return all();
  components_.emplace(id, Sought());
  if (!connected_) return;
  queue_.push_back({topics_.component_filter(id), id});
  next();
}

void Search::keep(OwnerId id) {
  component(id);
  const auto found = components_.find(id);
  if (all_ || found == components_.end()) return;
  ++found->second.needs;
  found->second.dropped = false;
}

/// Once all are looked for, they are not counted.
void Search::drop(OwnerId id) {
  const auto found = components_.find(id);
  if (!all_ && found != components_.end() && --found->second.needs == 0) found->second.dropped = true;
}

void Search::forget(OwnerId id) {
  const auto found = components_.find(id);
  if (all_ || found == components_.end() || !found->second.dropped) return;
  components_.erase(found);
  cancel(topics_.component_filter(id));
}

/// Forgets the components without a keep(). A request that waits for one of them calls component() again.
void Search::make_room() {
  std::erase_if(components_, [this](const auto& one) {
    const bool over = one.second.read && one.second.needs == 0;
    if (over) cancel(topics_.component_filter(one.first));
    return over;
  });
}

/// Of what is no longer looked for. A step that is under way ends without it.
void Search::cancel(const std::string& filter) {
  std::erase_if(queue_, [&](const Part& part) { return part.filter == filter; });
  for (auto& part : step_) {
    if (part.filter == filter) part = {};
  }
  if (connected_) callbacks_.unsubscribe(filter);
}

bool Search::line(const Line& line) {
  if (all_) return false;
  if (const auto known = lines_.find(line); known != lines_.end()) return !known->second;
  const auto unread = unread_.find(line.user);
  if (lines_.size() >= kMaxLines || (unread != unread_.end() && unread->second >= kMaxUnread)) return false;
  ++unread_[line.user];
  lines_.emplace(line, false);
  if (!connected_) return true;
  queue_.push_back({topics_.line_filter(line), {}, line});
  next();
  return true;
}

void Search::forget(const Line& line) {
  const auto found = lines_.find(line);
  if (found == lines_.end()) return;
  if (!found->second) count_read(line);
  cancel(topics_.line_filter(line));
  lines_.erase(found);
}

void Search::count_read(const Line& line) {
  const auto found = unread_.find(line.user);
  if (found != unread_.end() && --found->second == 0) unread_.erase(found);
}

bool Search::wants(const Line& line, std::optional<OwnerId> id) const {
  return all_ || (id && components_.contains(*id)) || lines_.contains(line);
}

bool Search::knows(OwnerId id) const {
  if (all_) return all_read_;
  const auto found = components_.find(id);
  return found != components_.end() && found->second.read && idle();
}

}  // namespace rubicon::tuples::mqtt
