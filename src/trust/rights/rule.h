#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::trust::rights {

/// What a member may do with a tuple, or with a device by message (docs/rights.md).
enum class Right : std::uint8_t { kRead, kDemand, kSet, kApprove, kSend };
inline constexpr Right kRights[] = {Right::kRead, Right::kDemand, Right::kSet, Right::kApprove, Right::kSend};
std::string_view to_string(Right right);
std::optional<Right> right_of(std::string_view word);

/// Several rights.
class RightSet {
 public:
  static RightSet all();
  void add(Right right) { bits_ |= bit(right); }
  void add(RightSet other) { bits_ |= other.bits_; }
  void remove(RightSet other) { bits_ &= static_cast<std::uint8_t>(~other.bits_); }
  bool has(Right right) const { return (bits_ & bit(right)) != 0; }
  bool empty() const { return bits_ == 0; }
  friend bool operator==(const RightSet&, const RightSet&) = default;

 private:
  static std::uint8_t bit(Right right) { return static_cast<std::uint8_t>(1U << static_cast<unsigned>(right)); }
  std::uint8_t bits_ = 0;
};

/// The word for Rule::names in `may`.
inline constexpr std::string_view kVouch = "vouch";

/// All members, except those of engine PEIS.
inline constexpr std::string_view kEverybody = "everybody";
/// In front of the id of an island: the member whose certificate has that id.
inline constexpr std::string_view kIsland = "island:";

/// In front of a name of this host or of the realm, which says where it comes from: `user:ann`, `user:1000`,
/// `group:staff`, `member:lab`, `role:cleaner`. Of another host the name is `user:ann@hall`: hall vouches for it; so
/// are `member:desk@hall` and, of a page, `token:tablet@hall`. `bridge:ha` is a bridge of this island.
inline constexpr std::string_view kUser = "user:", kGroup = "group:", kMember = "member:", kRole = "role:",
                                  kToken = "token:", kBridge = "bridge:";

/// One entry of `rights:`. It grants `may` to `who` for the tuples that match one of `keys` and none of `except`, and
/// denies it to them for those that match both.
struct Rule {
  std::vector<std::string>
      who;  ///< names, roles, names with their source, kEverybody, kIsland with an id, kLanMember, or kPeisMember
  RightSet may{};
  std::vector<std::string> keys{"**"};
  std::vector<std::string> except{};
  Duration interval{0};  ///< fastest demand; 0 = any
  /// Not empty: the rule lets `who` vouch for these names, in which `*` stands for any text, and says nothing of keys.
  std::vector<std::string> names{};
  std::string place{};  ///< `home.yaml:12:5`; empty = it stands in no file

  /// The place does not count.
  friend bool operator==(const Rule& a, const Rule& b) {
    return a.who == b.who && a.may == b.may && a.keys == b.keys && a.except == b.except && a.interval == b.interval &&
           a.names == b.names;
  }
};

/// A name, a role, or one of the words above. kInvalid: it is none of them.
Result<void> check_who(std::string_view who);
/// kInvalid: no pattern of names such as `user:*`.
Result<void> check_vouched(std::string_view names);
/// kInvalid unless it is parts joined by dots: a part is `[A-Za-z0-9_-]+` in which `*` stands for any text, the last
/// may be `**` for any parts; or `island:<id>`, for messages.
Result<void> check_rule_key(std::string_view pattern);

/// The key under which the proxy keeps what is asked for: that of a property has two names (model/property_alias.h).
/// Rules, questions and the audit use this one.
std::string kept_key(std::string_view key);

}  // namespace rubicon::trust::rights
