#pragma once

#include <cstdint>
#include <unordered_set>
#include <vector>

namespace rubicon::tuples::peis {

/// The last ids that came, to drop what comes again. Bounded: the oldest is forgotten first.
class SeenIds {
 public:
  explicit SeenIds(std::size_t capacity) : capacity_(capacity) {}

  /// False: it was here.
  bool add(std::uint64_t id) {
    if (!ids_.insert(id).second) return false;
    if (ring_.size() < capacity_) return ring_.push_back(id), true;
    ids_.erase(ring_[oldest_]);
    ring_[oldest_] = id;
    oldest_ = (oldest_ + 1) % capacity_;
    return true;
  }
  bool contains(std::uint64_t id) const { return ids_.contains(id); }
  std::size_t size() const { return ring_.size(); }

 private:
  std::size_t capacity_;
  std::unordered_set<std::uint64_t> ids_;
  std::vector<std::uint64_t> ring_;
  std::size_t oldest_ = 0;
};

}  // namespace rubicon::tuples::peis
