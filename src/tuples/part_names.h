#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace rubicon::tuples {

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
  std::unordered_map<std::string_view, PartId> ids_;
};

}  // namespace rubicon::tuples
