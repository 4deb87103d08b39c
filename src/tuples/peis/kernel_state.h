#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/time.hpp"
#include "rubicon/tuple.hpp"
#include "tuples/link.h"
#include "tuples/peis/tuple_wire.h"

namespace rubicon::tuples::peis {

/// The own tuples of one start of a component, as kernels see them: keys that differ only in case are one tuple, and
/// its number on the wire rises also when it is deleted and made again, since kernels drop a number that is not above
/// the one before (peis.md, section 6.2, 17).
class OwnKeys {
 public:
  /// A key that is gone keeps its number for this time. Later its numbers begin above the numbers of all forgotten
  /// keys, because a delete may wait for a slow kernel for minutes.
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

/// What one kernel pushed: appends come without the value before, and a kernel sends what it has only once. Translates
/// its numbers to sequences of ours, which also rise with each append. Bounded.
class KernelCopies {
 public:
  static constexpr std::size_t kMaxCopies = 200'000;
  static constexpr std::size_t kMaxBytes = std::size_t{128} * 1024 * 1024;

  struct Copy {
    std::string key;  ///< as the kernel spells it
    std::string data;
    std::string media_type;
    Encoding encoding = Encoding::kAscii;
    OwnerId owner{}, creator{};
    WallTime write_time{}, user_time{}, expire_time{};
    std::uint32_t number = 0;    ///< of the last set
    std::uint32_t appends = 0;   ///< since then
    std::uint64_t sequence = 0;  ///< of ours
    bool confirmed = true;       ///< since begin_round()
    SteadyTime expires{};        ///< max() = never
  };

  enum class News { kNew, kOld, kNoRoom };
  /// Takes a push that is not a delete. kOld: the number is not above that of the copy, and nothing was appended.
  News take(const NetworkTuple& tuple, SteadyTime now);
  /// Applies an append to all copies it means; those with another number are left alone, as kernels do. The pointers
  /// are valid until the next change. Entries without room are counted.
  std::vector<const Copy*> append(const PushAppended& appended);
  /// Null: not there.
  const Copy* find(std::string_view key) const;
  /// The copy that was there.
  std::optional<Copy> remove(std::string_view key);
  void each(std::string_view pattern, const std::function<void(const Copy&)>& visit) const;

  /// The kernel deleted its knowledge of this component, or a new start of it: each value counts again.
  void begin_round();
  /// Removes copies that match and were not pushed since begin_round().
  void end_round(std::string_view pattern);

  /// Removes copies whose lifetime is over: kernels do so by themselves, and send no message.
  void expire(SteadyTime now);
  /// SteadyTime::max() = none expires.
  SteadyTime next_expiry() const { return expiries_.empty() ? SteadyTime::max() : expiries_.begin()->first; }

  std::size_t size() const { return copies_.size(); }
  /// Appends to copies that there was no room for.
  std::uint64_t refused_appends() const { return refused_appends_; }

 private:
  using Copies = std::map<std::string, Copy, std::less<>>;
  void forget(const Copies::value_type& item);
  static std::size_t size_of(const Copy& copy) { return copy.key.size() + copy.data.size() + copy.media_type.size(); }

  Copies copies_;  ///< by folded key
  std::set<std::pair<SteadyTime, std::string>> expiries_;
  std::size_t bytes_ = 0;
  std::uint64_t refused_appends_ = 0;
};

/// For the tuple space; the views are those of the copy.
TupleView view_of(const KernelCopies::Copy& copy, std::string_view key);

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
    std::string pattern;              ///< as received, in our notation
    std::string media_type;           ///< empty = any type
    std::optional<OwnerId> creator;   ///< nullopt = any creator
    std::vector<Spelling> spellings;  ///< the first is the pattern as received
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
