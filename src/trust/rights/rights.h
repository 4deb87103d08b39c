#pragma once

#include <list>
#include <set>

#include "trust/rights/member_rights.h"
#include "tuples/judge.h"

namespace rubicon::trust::rights {

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
  /// How often the rules of a member were compiled: once for each, as long as they are not more than kMaxKept.
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

}  // namespace rubicon::trust::rights
