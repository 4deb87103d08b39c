#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "trust/rights/rule.h"

namespace rubicon::trust::rights {

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

}  // namespace rubicon::trust::rights
