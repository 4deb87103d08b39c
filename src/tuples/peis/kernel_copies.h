#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "rubicon/tuple.hpp"
#include "tuples/peis/tuple_wire.h"

namespace rubicon::tuples::peis {

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
  /// Takes a push that is no delete. kOld: the number is not above that of the copy, and nothing was appended.
  News take(const NetworkTuple& tuple, SteadyTime now);
  /// Applies an append to all copies it means; those with another number are left alone, as kernels do. The pointers
  /// are valid until the next change. What there is no room for is counted.
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

}  // namespace rubicon::tuples::peis
