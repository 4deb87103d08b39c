#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/hash_index.h"
#include "rubicon/key.hpp"

namespace rubicon::tuples {

/// A vector that grows by pages: elements never move, and at most one page is unused, whereas a std::vector may reserve
/// twice its size.
template <class T>
class Pages {
 public:
  T& operator[](std::uint32_t index) { return pages_[index / kPage][index % kPage]; }
  const T& operator[](std::uint32_t index) const { return pages_[index / kPage][index % kPage]; }
  std::uint32_t size() const { return size_; }
  /// Returns the index of the new element.
  std::uint32_t add() {
    if (size_ % kPage == 0) pages_.push_back(std::make_unique<T[]>(kPage));
    return size_++;
  }

 private:
  static constexpr std::uint32_t kPage = 256;

  std::vector<std::unique_ptr<T[]>> pages_;
  std::uint32_t size_ = 0;
};

/// Number of an interned key part.
using PartId = std::uint32_t;
inline constexpr PartId kNoPart = 0xffffffff;
inline constexpr PartId kAnyPart = 0;  ///< `*`
inline constexpr PartId kAnyRest = 1;  ///< `**`

/// Interned key parts with reference counts, so that the parts of deleted tuples are freed.
class PartNames {
 public:
  PartNames();

  PartId find(std::string_view text) const;
  /// Each acquire() needs a release().
  PartId acquire(std::string_view text);
  void acquire(PartId part) { ++entries_[part].uses; }
  void release(PartId part);
  std::size_t size() const { return ids_.size(); }

 private:
  struct Entry {
    std::string text;
    std::uint32_t uses = 0;
  };
  std::deque<Entry> entries_;
  std::vector<PartId> free_;
  base::HashIndex ids_;
};

/// (node, part) -> child node, for all nodes of a trie: one open-addressing table of 12-byte slots.
class ChildTable {
 public:
  static constexpr std::uint32_t kNone = 0xffffffff;

  ChildTable() : slots_(16) {}

  std::uint32_t find(std::uint32_t node, std::uint32_t part) const;
  /// The pair must not be there yet.
  void add(std::uint32_t node, std::uint32_t part, std::uint32_t child);
  void remove(std::uint32_t node, std::uint32_t part);

 private:
  struct Slot {
    std::uint32_t node = 0;
    std::uint32_t part = 0;
    std::uint32_t child = kNone;
  };
  std::size_t home(std::uint32_t node, std::uint32_t part) const;
  void place(const Slot& slot);
  void grow();

  std::vector<Slot> slots_;  // a power of two
  std::size_t used_ = 0;
};

inline constexpr std::uint32_t kNone = 0xffffffff;

/// A key or pattern as interned parts; the first part is the owner (or `*`).
struct PartPath {
  std::array<PartId, model::kMaxKeyParts + 1> parts{};
  std::size_t size = 0;
};

class PatternWalk;

/// A tree of interned parts. A node may have a payload, a number defined by the user of the trie. The names must
/// outlive it.
class PartTrie {
 public:
  static constexpr std::uint32_t kRoot = 0;

  explicit PartTrie(PartNames& names);

  /// The key must be a valid key or pattern.
  std::uint32_t add(std::optional<model::OwnerId> owner, std::string_view key);
  std::uint32_t find(std::optional<model::OwnerId> owner, std::string_view key) const;

  bool has_owner(model::OwnerId owner) const;

  std::uint32_t payload(std::uint32_t node) const { return nodes_[node].payload; }
  void set_payload(std::uint32_t node, std::uint32_t payload) { nodes_[node].payload = payload; }
  /// Removes the payload and all nodes that become unused.
  void clear(std::uint32_t node);

  /// The key of a node.
  PartPath path(std::uint32_t node) const;
  /// The payloads of all patterns in this trie that match a concrete key, of this trie or another with the same names.
  void matching(const PartPath& path, std::vector<std::uint32_t>& payloads) const {
    match_from(kRoot, path, 0, payloads);
  }

  std::uint32_t child(std::uint32_t node, PartId part) const;
  std::uint32_t first_child(std::uint32_t node) const { return nodes_[node].first_child; }
  std::uint32_t next_sibling(std::uint32_t node) const { return nodes_[node].next_sibling; }
  PartNames& names() const { return *names_; }

 private:
  friend class PatternWalk;
  struct Node {
    std::uint32_t parent = kNone;
    PartId part = kNoPart;
    std::uint32_t first_child = kNone;
    std::uint32_t next_sibling = kNone;
    std::uint32_t previous_sibling = kNone;
    std::uint32_t payload = kNone;
    std::uint32_t children : 31 = 0;
    std::uint32_t indexed : 1 = 0;  ///< its children are in the table
  };
  /// Up to this many children are searched one by one, which is faster than the table because they are adjacent.
  static constexpr std::uint32_t kFewChildren = 8;
  std::uint32_t begin_near_last(std::optional<model::OwnerId> owner, std::string_view& key);
  std::uint32_t make_child(std::uint32_t node, std::string_view part);
  std::uint32_t take_free_node();
  void link(std::uint32_t parent, std::uint32_t node);
  void unlink(std::uint32_t node);
  void match_from(std::uint32_t node, const PartPath& path, std::size_t at, std::vector<std::uint32_t>& payloads) const;

  PartNames* names_;
  Pages<Node> nodes_;
  std::vector<std::uint32_t> free_;
  ChildTable children_;
  std::vector<PatternWalk*> walks_;
  std::uint32_t last_added_ = kNone;  ///< kNone: it has gone since
  std::optional<model::OwnerId> last_owner_;
  std::string last_key_;
};

/// Visits the payloads that match a pattern, a few nodes at a time. The trie may change in between: removed nodes are
/// skipped, new ones may or may not be visited. The trie must outlive it.
class PatternWalk {
 public:
  PatternWalk(PartTrie& trie, const model::Pattern& pattern);
  ~PatternWalk();
  PatternWalk(const PatternWalk&) = delete;
  PatternWalk& operator=(const PatternWalk&) = delete;

  /// The next payload; nullopt if the walk is complete or the budget of nodes is used up.
  std::optional<std::uint32_t> next(std::size_t& budget);
  bool done() const { return depth_ == 0; }

 private:
  friend class PartTrie;
  struct Frame {
    std::uint32_t node = kNone;
    std::uint32_t cursor = kNone;  ///< the child to enter next
    std::size_t at = 0;            ///< index of the pattern's part that children must match
  };
  void enter(std::uint32_t node, std::size_t at);
  bool any_rest(std::size_t at) const { return at < pattern_.size && pattern_.parts[at] == kAnyRest; }
  void forget(std::uint32_t node);

  PartTrie& trie_;
  PartPath pattern_;
  std::array<Frame, model::kMaxKeyParts + 2> frames_{};
  std::size_t depth_ = 0;
};

}  // namespace rubicon::tuples
