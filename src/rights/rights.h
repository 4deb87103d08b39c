#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "rubicon/result.hpp"
#include "rubicon/time.hpp"
#include "tuples/judge.h"

namespace rubicon::rights {

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

/// The word in `may` of a rule with Rule::names.
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

/// The key under which the proxy keeps the requested tuple: the key of a property has two names (model/type_names.h).
/// Rules, questions and the audit use this one.
std::string kept_key(std::string_view key);

/// The rules that concern one member, as a tree of the parts of their patterns: a key is compared with few of them.
class MemberRights {
 public:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  /// What all rules together say about a key.
  struct Finding {
    RightSet granted{};    ///< without what is denied
    RightSet denied{};     ///< by an exception of a rule
    Duration interval{0};  ///< of the rule that grants the fastest demand; 0 = any
    std::size_t by[std::size(kRights)] = {kNone, kNone, kNone, kNone,
                                          kNone};  ///< by right: the first rule that decides
  };

  /// `rule`: its number among all, in ascending order.
  void add(const Rule& rule, std::size_t number);
  Finding find(std::string_view key) const;
  /// The same for a place that reaches all below it: exceptions there deny it too, if their rule allows something
  /// there.
  Finding find_whole(std::string_view place) const;
  /// Whether it grants reading and any demand of every key.
  bool sees_all() const;

 private:
  struct Hash {
    using is_transparent = void;
    std::size_t operator()(std::string_view text) const { return std::hash<std::string_view>()(text); }
  };
  /// The pattern that ends here is of that rule.
  struct Mark {
    std::uint32_t rule = 0;  ///< in rules_
    bool except = false;
  };
  struct Node {
    std::unordered_map<std::string, std::uint32_t, Hash, std::equal_to<>> exact;
    std::vector<std::pair<std::string, std::uint32_t>> globs;
    std::uint32_t any = 0;  ///< the child for `*`; 0 = none
    std::vector<Mark> here, rest;
  };
  struct Known {
    std::size_t number = 0;
    RightSet may{};
    Duration interval{0};
  };
  using Marks = std::vector<Mark>;

  void add(std::string_view pattern, Mark mark);
  std::uint32_t child(std::uint32_t node, std::string_view part);
  std::uint32_t make_node();
  void collect(std::uint32_t node, std::string_view rest, bool over, Marks& marks) const;
  void collect_all(std::uint32_t node, Marks& marks) const;
  template <class Visit>
  void each_rule(Visit visit) const;
  void judge(const Mark* first, const Mark* last, Finding& finding) const;

  std::vector<Node> nodes_ = std::vector<Node>(1);
  std::vector<Known> rules_;
  bool has_exceptions_ = false;
  mutable Marks marks_;  ///< of the last search, kept for its memory
};

/// What the rules say about one question.
struct Decision {
  bool allowed = false;
  std::optional<std::size_t> rule{};  ///< the number of the rule that decides, from 0; nullopt: no rule allows it
  std::string text{};                 ///< `rule 2 (home.yaml:12:5) allows it`, `rule 3 denies it`, `no rule allows it`
};

/// All rules of an owner. Whether a member may do something does not depend on their order: what one rule denies, no
/// other allows; what no rule allows is denied (docs/rights.md).
class Rights {
 public:
  /// Without `rights:`: members with the role `admin` may do everything, others may do nothing.
  Rights();
  /// The rules must be sound: check_who(), check_rule_key().
  explicit Rights(std::vector<Rule> rules);
  Rights(Rights&&) = default;
  Rights& operator=(Rights&&) = default;

  const std::vector<Rule>& rules() const { return rules_; }

  Decision decide(const tuples::Member& who, Right right, std::string_view key) const;
  tuples::Access access(const tuples::Member& who, std::string_view key) const;
  /// Whether a rule lets the member vouch for that name.
  bool may_vouch(const tuples::Member& who, std::string_view name) const;
  bool sees_all(const tuples::Member& who) const;
  /// How often the rules of members were compiled: once for each member, up to kMaxKept members.
  std::uint64_t compiled() const { return compiled_; }

  /// Members whose rules are kept in their compiled form.
  static constexpr std::size_t kMaxKept = 1024;

 private:
  struct Kept {
    tuples::Member who;
    MemberRights rights{};
  };
  using Order = std::list<Kept>;
  /// By all that rules ask of a member.
  struct Before {
    using is_transparent = void;
    static const tuples::Member& who(const tuples::Member& one) { return one; }
    static const tuples::Member& who(Order::iterator one) { return one->who; }
    template <class A, class B>
    bool operator()(const A& a, const B& b) const {
      return is_before(who(a), who(b));
    }
    static bool is_before(const tuples::Member& a, const tuples::Member& b);
  };
  const MemberRights& of(const tuples::Member& who) const;
  bool concerns(const Rule& rule, const tuples::Member& who) const;

  std::vector<Rule> rules_;
  bool only_admins_ = false;
  mutable Order kept_;  ///< the one that was asked for last is the first
  mutable std::set<Order::iterator, Before> by_member_;
  mutable std::uint64_t compiled_ = 0;
};

}  // namespace rubicon::rights
