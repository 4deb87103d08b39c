#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "rubicon/time.hpp"
#include "tuples/change.h"

namespace rubicon::tuples::peis {

/// The own tuples of one start of a component, as kernels see them: keys that differ only in case are one tuple, and
/// its number on the wire rises also when it is deleted and made again, since kernels drop a number that is not above
/// the one before (peis.md, section 6.2, 17).
class OwnKeys {
 public:
  /// A key that is gone keeps its number for this time. Later its numbers begin above those of all keys that are
  /// forgotten: a delete may wait for a slow kernel for minutes.
  static constexpr Duration kKeepGone = std::chrono::seconds(30);

  /// A tuple exists: it may be new. Whether kernels see it: false if one whose key differs only in case came first.
  bool add(std::string_view key);
  /// Whether kernels saw it.
  bool remove(std::string_view key, SteadyTime now);

  /// The spelling of the present tuple that kernels know by this key; null: none.
  const std::string* spelling(std::string_view key) const;
  /// Calls `visit` with each key that matches the key of a Pattern, as kernels compare.
  void each(std::string_view pattern, const std::function<void(const std::string&)>& visit) const;
  std::size_t size() const { return present_; }
  /// Whether a present key has capital letters.
  bool has_capitals() const { return capitals_ > 0; }
  /// `(first k1 k2 ...)`, as in kernel.all-keys: `first` and whole keys that kernels can have, up to `limit` bytes.
  std::string list(std::string_view first, std::size_t limit) const;

  /// The number for a version of a tuple that add() accepted: equal for equal versions, else higher than before.
  std::uint32_t number_of(const TupleView& tuple);
  std::uint32_t number_of(const TupleGone& gone);

 private:
  struct Version {
    std::uint64_t sequence = 0;
    WallTime written{};
    bool gone = false;
    friend bool operator==(const Version&, const Version&) = default;
  };
  struct Entry {
    std::string spelling;
    bool present = false;
    bool numbered = false;
    std::uint32_t number = 0;
    Version version;
    SteadyTime gone_at{};
  };

  std::uint32_t number_of(std::string_view key, const Version& version, std::uint32_t least);
  void drop_gone(SteadyTime now);

  std::map<std::string, Entry, std::less<>> entries_;  ///< by folded key
  std::deque<std::pair<SteadyTime, std::string>> gone_;
  std::size_t present_ = 0, capitals_ = 0;
  std::uint32_t least_ = 0;  ///< above the numbers of all entries that were dropped
};

}  // namespace rubicon::tuples::peis
