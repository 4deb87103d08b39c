#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "rubicon/time.hpp"
#include "tuples/peis/tuple_wire.h"

namespace rubicon::tuples::peis {

/// The subscriptions of one kernel to our tuples. A kernel sends each one several times, and one UNSUBSCRIBE for each
/// of its handles, which says the key and the data only (peis.md, section 6.3).
class KernelSubscribers {
 public:
  static constexpr std::size_t kMaxEntries = 10'000;
  static constexpr std::size_t kMaxSpellings = 16;  ///< of one subscription
  static constexpr std::size_t kMaxData = 1024;     ///< bytes that one subscription compares with
  static constexpr std::size_t kMaxDataOfAll = 1024 * 1024;
  /// Copies without force that come within this time of each other are one round of all subscriptions.
  static constexpr Duration kRoundGap = std::chrono::seconds(1);

  /// A subscription under one spelling of its pattern: ids and patterns as in SubscriptionSpec.
  struct Spelling {
    std::uint32_t id = 0;
    std::string pattern;
    bool snapshot_under_way = false;
    bool again = false;  ///< pushes of that snapshot were lost: another one follows
  };
  struct Entry {
    std::string pattern;              ///< as it came, in our form
    std::string media_type;           ///< empty = any
    std::optional<OwnerId> creator;   ///< empty = any
    std::vector<Spelling> spellings;  ///< the first is the pattern as it came
    unsigned forced = 0;              ///< copies with force since the host was met
    unsigned in_round = 0, forced_since = 0;
    std::uint64_t round = 0;
  };

  /// By folded key and data.
  using Name = std::pair<std::string, std::optional<std::string>>;
  using Entries = std::map<Name, Entry>;

  /// Counts a copy. kInvalid: no pattern of ours; kOutOfRange: its data are too long; kBusy: too many.
  Result<Entry*> add(const Subscribe& subscribe, SteadyTime now);
  /// The ids that end.
  std::vector<std::uint32_t> remove(const Unsubscribe& unsubscribe);
  /// The kernel meets this component again, and will send what it has: counts anew, but keeps all until then. The ids.
  std::vector<std::uint32_t> begin_again();

  std::vector<std::uint32_t> ids() const;
  /// Calls `visit` with each one whose pattern matches the key.
  void each_for(std::string_view key, const std::function<void(Entry&)>& visit);

  /// Another spelling for an own key that none of the present ones matches; null: not needed, or too many.
  const Spelling* add_spelling(Entry& entry, std::string_view key);
  /// Null: it has ended.
  Spelling* find(std::uint32_t id);
  const Entries& entries() const { return entries_; }
  /// Whether one of them is for this tuple, by key, media type, data and creator. Data is as on the wire.
  /// Subscriptions by key alone are taken for granted: the space has matched them.
  bool wants(std::string_view key, std::string_view media_type, std::string_view data, OwnerId creator) const;

 private:
  std::uint32_t next_id();
  using Item = Entries::value_type;
  Result<Item*> obtain(const NetworkTuple& prototype);
  Result<void> check_room(const Name& name) const;
  void count(Entry& entry, bool forced, SteadyTime now);
  static bool is_filter(const Item& item);
  static std::size_t data_size(const Name& name) { return name.second ? name.second->size() : 0; }
  bool any_for(std::string_view key, const std::function<bool(const Item&)>& is_it) const;

  Entries entries_;
  std::map<std::uint32_t, Item*> by_id_;
  std::map<std::uint32_t, Item*> wild_;  ///< with `*` in their patterns, by their first id
  std::uint32_t last_id_ = 0;
  std::uint64_t round_ = 0;
  std::size_t filters_ = 0;  ///< entries that want more than a key
  std::size_t data_bytes_ = 0;
  SteadyTime last_of_round_ = SteadyTime::min();
};

}  // namespace rubicon::tuples::peis
