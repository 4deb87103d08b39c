#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "rubicon/tuple_space.hpp"
#include "tuples/pages.h"
#include "tuples/part_trie.h"

namespace rubicon::tuples {

/// Interned media types. Bounded, because peers send them: beyond the limit a type becomes
/// `application/octet-stream`.
class MediaTypes {
 public:
  static constexpr std::size_t kMaxTypes = 4096;
  static constexpr std::size_t kMaxLength = 254;

  MediaTypes() : names_{"application/octet-stream", "text/plain", "application/json"} {}

  std::uint16_t intern(std::string_view name);
  std::string_view name(std::uint16_t id) const { return names_[id]; }

 private:
  std::deque<std::string> names_;  // views into them stay valid
};

/// One tuple in the store. A deleted one stays in memory while events about it are queued (pins). Aligned to a pair of
/// cache lines, because tuples are visited in random order.
struct alignas(128) Tuple {
  std::unique_ptr<char[]> key_text;
  std::string value;
  std::uint64_t sequence = 0;
  WallTime write_time{};
  WallTime user_time{};
  WallTime expire_time{};
  OwnerId owner{};
  OwnerId creator{};
  std::uint32_t generation = 0;  ///< differs from all earlier tuples with this index
  std::uint32_t node = kNone;
  std::uint32_t subscribers = 0;  ///< id of an interned set
  std::uint32_t pins = 0;
  std::uint16_t media_type = 0;
  std::uint16_t epoch = 0;  ///< of a copy: the owner's epoch in which it was last confirmed
  std::uint8_t key_size = 0;
  bool present = false;
  EventKind end = EventKind::kDeleted;  ///< how it ended, if not present

  std::string_view key() const { return {key_text.get(), key_size}; }
};

/// Tuples by index; they never move.
class TuplePool {
 public:
  Tuple& operator[](std::uint32_t index) { return tuples_[index]; }
  const Tuple& operator[](std::uint32_t index) const { return tuples_[index]; }
  bool contains(std::uint32_t index) const { return index < tuples_.size(); }

  std::uint32_t take(OwnerId owner, std::string_view key);
  /// Marks the tuple as gone; its memory is reused after the last unpin().
  void end(std::uint32_t index, EventKind how);
  void pin(std::uint32_t index) { ++(*this)[index].pins; }
  void unpin(std::uint32_t index);

  std::uint32_t generation() const { return generation_; }

 private:
  void release(std::uint32_t index);

  Pages<Tuple> tuples_;
  std::vector<std::uint32_t> free_;
  std::uint32_t generation_ = 0;
};

}  // namespace rubicon::tuples
