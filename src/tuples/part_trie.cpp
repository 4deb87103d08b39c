#include "tuples/part_trie.h"

#include <algorithm>
#include <charconv>
#include <functional>

#include "base/assert.h"

namespace rubicon::tuples {

namespace {

std::uint32_t hash_of_part(std::string_view part) {
  return static_cast<std::uint32_t>(std::hash<std::string_view>{}(part) >> 32);
}

}  // namespace

PartNames::PartNames() {
  RUBICON_ASSERT(acquire("*") == kAnyPart);
  RUBICON_ASSERT(acquire("**") == kAnyRest);
}

static_assert(kNoPart == base::HashIndex::kNone);

PartId PartNames::find(std::string_view text) const {
  return ids_.find(hash_of_part(text), [&](PartId part) { return entries_[part].text == text; });
}

PartId PartNames::acquire(std::string_view text) {
  PartId part = find(text);
  if (part == kNoPart) {
    if (free_.empty()) {
      part = static_cast<PartId>(entries_.size());
      entries_.emplace_back();
    } else {
      part = free_.back();
      free_.pop_back();
    }
    entries_[part].text = text;
    ids_.add(hash_of_part(text), part);
  }
  ++entries_[part].uses;
  return part;
}

void PartNames::release(PartId part) {
  auto& entry = entries_[part];
  RUBICON_DEBUG_ASSERT(entry.uses > 0);
  if (--entry.uses > 0) return;
  ids_.remove(hash_of_part(entry.text), part);
  entry.text = std::string();
  free_.push_back(part);
}

std::size_t ChildTable::home(std::uint32_t node, std::uint32_t part) const {
  std::uint64_t mixed = (std::uint64_t{node} << 32) | part;
  mixed = (mixed ^ (mixed >> 31)) * 0x9e3779b97f4a7c15u;
  mixed ^= mixed >> 32;
  return static_cast<std::size_t>(mixed) & (slots_.size() - 1);
}

std::uint32_t ChildTable::find(std::uint32_t node, std::uint32_t part) const {
  for (auto at = home(node, part);; at = (at + 1) & (slots_.size() - 1)) {
    const auto& slot = slots_[at];
    if (slot.child == kNone || (slot.node == node && slot.part == part)) return slot.child;
  }
}

void ChildTable::add(std::uint32_t node, std::uint32_t part, std::uint32_t child) {
  if ((used_ + 1) * 4 > slots_.size() * 3) grow();
  place({node, part, child});
  ++used_;
}

void ChildTable::place(const Slot& slot) {
  auto at = home(slot.node, slot.part);
  while (slots_[at].child != kNone) at = (at + 1) & (slots_.size() - 1);
  slots_[at] = slot;
}

void ChildTable::remove(std::uint32_t node, std::uint32_t part) {
  const auto mask = slots_.size() - 1;
  auto hole = home(node, part);
  while (slots_[hole].child != kNone && (slots_[hole].node != node || slots_[hole].part != part))
    hole = (hole + 1) & mask;
  if (slots_[hole].child == kNone) return;
  // Later slots of the same run move up, unless that would put them before their home.
  for (auto at = (hole + 1) & mask; slots_[at].child != kNone; at = (at + 1) & mask) {
    const auto from_home = (at - home(slots_[at].node, slots_[at].part)) & mask;
    if (from_home < ((at - hole) & mask)) continue;
    slots_[hole] = slots_[at];
    hole = at;
  }
  slots_[hole] = {};
  --used_;
}

void ChildTable::grow() {
  auto old = std::move(slots_);
  slots_ = std::vector<Slot>(old.size() * 2);
  for (const auto& slot : old) {
    if (slot.child != kNone) place(slot);
  }
}

namespace {

/// An owner as the text of a part: it is the first level of the trie.
class OwnerPart {
 public:
  explicit OwnerPart(std::optional<model::OwnerId> owner) {
    if (owner) size_ = static_cast<std::size_t>(std::to_chars(text_, text_ + sizeof text_, number(*owner)).ptr - text_);
  }
  std::string_view text() const { return size_ == 0 ? std::string_view("*") : std::string_view(text_, size_); }

 private:
  char text_[12];
  std::size_t size_ = 0;
};

template <class Visit>
void each_part(std::string_view key, Visit visit) {
  while (true) {
    const auto dot = key.find('.');
    if (!visit(key.substr(0, dot)) || dot == key.npos) return;
    key.remove_prefix(dot + 1);
  }
}

}  // namespace

PartTrie::PartTrie(PartNames& names) : names_(&names) {
  nodes_.add();
}

std::uint32_t PartTrie::add(std::optional<model::OwnerId> owner, std::string_view key) {
  auto rest = key;
  auto node = begin_near_last(owner, rest);
  each_part(rest, [&](std::string_view part) {
    node = make_child(node, part);
    return true;
  });
  last_added_ = node;
  last_owner_ = owner;
  last_key_ = key;
  return node;
}

/// Keys that are added one after the other often differ in their last parts only: removes the first parts that both
/// have, and returns the node of these.
std::uint32_t PartTrie::begin_near_last(std::optional<model::OwnerId> owner, std::string_view& key) {
  if (last_added_ == kNone || last_owner_ != owner) return make_child(kRoot, OwnerPart(owner).text());
  const auto differ = std::mismatch(key.begin(), key.end(), last_key_.begin(), last_key_.end()).first;
  const auto same = key.substr(0, static_cast<std::size_t>(differ - key.begin())).rfind('.') + 1;  // npos + 1 = 0
  auto node = nodes_[last_added_].parent;
  for (auto at = same; (at = last_key_.find('.', at)) != last_key_.npos; ++at) node = nodes_[node].parent;
  key.remove_prefix(same);
  return node;
}

std::uint32_t PartTrie::find(std::optional<model::OwnerId> owner, std::string_view key) const {
  const auto down = [&](std::uint32_t from, std::string_view text) {
    const auto part = names_->find(text);
    return part == kNoPart ? kNone : child(from, part);
  };
  auto node = down(kRoot, OwnerPart(owner).text());
  if (node == kNone) return kNone;
  each_part(key, [&](std::string_view part) {
    node = down(node, part);
    return node != kNone;
  });
  return node;
}

bool PartTrie::has_owner(model::OwnerId owner) const {
  const auto part = names_->find(OwnerPart(owner).text());
  return part != kNoPart && child(kRoot, part) != kNone;
}

std::uint32_t PartTrie::make_child(std::uint32_t node, std::string_view text) {
  const auto part = names_->acquire(text);
  if (const auto there = child(node, part); there != kNone) {
    names_->release(part);
    return there;
  }
  const auto made = take_free_node();
  nodes_[made].part = part;
  link(node, made);
  return made;
}

std::uint32_t PartTrie::child(std::uint32_t node, PartId part) const {
  if (nodes_[node].indexed) return children_.find(node, part);
  auto at = nodes_[node].first_child;
  while (at != kNone && nodes_[at].part != part) at = nodes_[at].next_sibling;
  return at;
}

void PartTrie::link(std::uint32_t parent, std::uint32_t node) {
  auto& above = nodes_[parent];
  auto& made = nodes_[node];
  made.parent = parent;
  made.next_sibling = above.first_child;
  if (made.next_sibling != kNone) nodes_[made.next_sibling].previous_sibling = node;
  above.first_child = node;
  ++above.children;
  if (above.indexed) {
    children_.add(parent, made.part, node);
  } else if (above.children > kFewChildren) {
    above.indexed = 1;
    for (auto at = node; at != kNone; at = nodes_[at].next_sibling) children_.add(parent, nodes_[at].part, at);
  }
}

std::uint32_t PartTrie::take_free_node() {
  if (free_.empty()) return nodes_.add();
  const auto node = free_.back();
  free_.pop_back();
  return node;
}

void PartTrie::clear(std::uint32_t node) {
  nodes_[node].payload = kNone;
  while (node != kRoot && nodes_[node].payload == kNone && nodes_[node].first_child == kNone) {
    const auto parent = nodes_[node].parent;
    unlink(node);
    node = parent;
  }
}

void PartTrie::unlink(std::uint32_t node) {
  for (auto* walk : walks_) walk->forget(node);
  const auto gone = nodes_[node];
  if (gone.previous_sibling == kNone) {
    nodes_[gone.parent].first_child = gone.next_sibling;
  } else {
    nodes_[gone.previous_sibling].next_sibling = gone.next_sibling;
  }
  if (gone.next_sibling != kNone) nodes_[gone.next_sibling].previous_sibling = gone.previous_sibling;
  auto& above = nodes_[gone.parent];
  if (above.indexed) children_.remove(gone.parent, gone.part);
  if (--above.children == 0) above.indexed = 0;
  names_->release(gone.part);
  nodes_[node] = {};
  free_.push_back(node);
  if (node == last_added_) last_added_ = kNone;
}

PartPath PartTrie::path(std::uint32_t node) const {
  PartPath path;
  for (; node != kRoot; node = nodes_[node].parent) path.parts[path.size++] = nodes_[node].part;
  std::reverse(path.parts.begin(), path.parts.begin() + static_cast<std::ptrdiff_t>(path.size));
  return path;
}

void PartTrie::match_from(std::uint32_t node, const PartPath& path, std::size_t at,
                          std::vector<std::uint32_t>& payloads) const {
  if (nodes_[node].first_child != kNone) {
    if (const auto rest = child(node, kAnyRest); rest != kNone) payloads.push_back(nodes_[rest].payload);
  }
  if (at == path.size) {
    if (nodes_[node].payload != kNone) payloads.push_back(nodes_[node].payload);
    return;
  }
  if (const auto exact = child(node, path.parts[at]); exact != kNone) match_from(exact, path, at + 1, payloads);
  if (const auto any = child(node, kAnyPart); any != kNone) match_from(any, path, at + 1, payloads);
}

PatternWalk::PatternWalk(PartTrie& trie, const model::Pattern& pattern) : trie_(trie) {
  auto& names = trie_.names();
  pattern_.parts[pattern_.size++] = names.acquire(OwnerPart(pattern.owner).text());
  each_part(pattern.key, [&](std::string_view part) {
    pattern_.parts[pattern_.size++] = names.acquire(part);
    return true;
  });
  trie_.walks_.push_back(this);
  enter(PartTrie::kRoot, 0);
}

PatternWalk::~PatternWalk() {
  for (std::size_t i = 0; i < pattern_.size; ++i) trie_.names().release(pattern_.parts[i]);
  std::erase(trie_.walks_, this);
}

void PatternWalk::enter(std::uint32_t node, std::size_t at) {
  auto& frame = frames_[depth_++];
  frame = {node, kNone, at};
  if (at >= pattern_.size) return;
  const auto part = pattern_.parts[at];
  const bool wild = part == kAnyPart || part == kAnyRest;
  frame.cursor = wild ? trie_.first_child(node) : trie_.child(node, part);
}

std::optional<std::uint32_t> PatternWalk::next(std::size_t& budget) {
  while (depth_ > 0 && budget > 0) {
    auto& frame = frames_[depth_ - 1];
    const auto node = frame.cursor;
    if (node == kNone) {
      --depth_;
      continue;
    }
    --budget;
    const bool rest = any_rest(frame.at);
    frame.cursor = rest || pattern_.parts[frame.at] == kAnyPart ? trie_.next_sibling(node) : kNone;
    const auto at = rest ? frame.at : frame.at + 1;
    enter(node, at);
    const auto payload = trie_.payload(node);
    if (payload != kNone && (at == pattern_.size || any_rest(at))) return payload;
  }
  return std::nullopt;
}

void PatternWalk::forget(std::uint32_t node) {
  for (std::size_t i = 0; i < depth_; ++i) {
    if (frames_[i].cursor == node) {
      const auto part = pattern_.parts[frames_[i].at];
      frames_[i].cursor = part == kAnyPart || part == kAnyRest ? trie_.next_sibling(node) : kNone;
    }
    if (frames_[i].node == node) frames_[i].cursor = kNone;
  }
}

}  // namespace rubicon::tuples
