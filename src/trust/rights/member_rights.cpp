#include "trust/rights/member_rights.h"

#include <algorithm>

#include "base/glob.h"

namespace rubicon::trust::rights {

namespace {

RightSet only(Right right) {
  RightSet set;
  set.add(right);
  return set;
}

}  // namespace

void MemberRights::add(const Rule& rule, std::size_t number) {
  const auto index = static_cast<std::uint32_t>(rules_.size());
  rules_.push_back({number, rule.may, rule.interval});
  for (const auto& key : rule.keys) add(key, {index, false});
  for (const auto& key : rule.except) add(key, {index, true});
  has_exceptions_ = has_exceptions_ || !rule.except.empty();
}

void MemberRights::add(std::string_view pattern, Mark mark) {
  std::uint32_t node = 0;
  while (true) {
    const auto dot = pattern.find('.');
    const auto part = pattern.substr(0, dot);
    if (part == "**") return nodes_[node].rest.push_back(mark);
    node = child(node, part);
    if (dot == pattern.npos) return nodes_[node].here.push_back(mark);
    pattern.remove_prefix(dot + 1);
  }
}

std::uint32_t MemberRights::make_node() {
  nodes_.emplace_back();
  return static_cast<std::uint32_t>(nodes_.size() - 1);
}

std::uint32_t MemberRights::child(std::uint32_t node, std::string_view part) {
  if (part == "*") {
    if (nodes_[node].any == 0) nodes_[node].any = make_node();
    return nodes_[node].any;
  }
  if (part.find('*') == part.npos) {
    if (const auto found = nodes_[node].exact.find(part); found != nodes_[node].exact.end()) return found->second;
    const auto made = make_node();
    nodes_[node].exact.emplace(part, made);
    return made;
  }
  for (const auto& [glob, at] : nodes_[node].globs) {
    if (glob == part) return at;
  }
  const auto made = make_node();
  nodes_[node].globs.emplace_back(part, made);
  return made;
}

void MemberRights::collect(std::uint32_t at, std::string_view rest, bool over, Marks& marks) const {
  const auto& node = nodes_[at];
  marks.insert(marks.end(), node.rest.begin(), node.rest.end());
  if (over) {
    marks.insert(marks.end(), node.here.begin(), node.here.end());
    return;
  }
  const auto dot = rest.find('.');
  const auto part = rest.substr(0, dot);
  const bool last = dot == rest.npos;
  if (!last) rest.remove_prefix(dot + 1);
  if (!node.exact.empty()) {
    if (const auto found = node.exact.find(part); found != node.exact.end()) collect(found->second, rest, last, marks);
  }
  if (node.any != 0) collect(node.any, rest, last, marks);
  for (const auto& [glob, child] : node.globs) {
    if (base::glob_matches(glob, part)) collect(child, rest, last, marks);
  }
}

/// The marks of one rule: those of its exceptions are the last.
void MemberRights::judge(const Mark* first, const Mark* last, Finding& finding) const {
  if (first->except) return;  // an exception to what the rule does not mention
  const auto& rule = rules_[first->rule];
  const bool denies = last[-1].except;
  auto& all = denies ? finding.denied : finding.granted;
  for (const auto right : kRights) {
    const bool first_of_all = !finding.denied.has(right) && (denies || !finding.granted.has(right));
    if (rule.may.has(right) && first_of_all) finding.by[static_cast<std::size_t>(right)] = rule.number;
  }
  if (!denies && rule.may.has(Right::kDemand))
    finding.interval = all.has(Right::kDemand) ? std::min(finding.interval, rule.interval) : rule.interval;
  all.add(rule.may);
}

/// Visits the marks that were collected, by rule.
template <class Visit>
void MemberRights::each_rule(Visit visit) const {
  std::sort(marks_.begin(), marks_.end(),
            [](const Mark& a, const Mark& b) { return a.rule != b.rule ? a.rule < b.rule : a.except < b.except; });
  const auto* const end = marks_.data() + marks_.size();
  for (const auto* at = marks_.data(); at != end;) {
    const auto* next = at;
    while (next != end && next->rule == at->rule) ++next;
    visit(at, next);
    at = next;
  }
}

MemberRights::Finding MemberRights::find(std::string_view key) const {
  marks_.clear();
  collect(0, key, false, marks_);
  Finding finding;
  each_rule([&](const Mark* first, const Mark* last) { judge(first, last, finding); });
  finding.granted.remove(finding.denied);
  return finding;
}

MemberRights::Finding MemberRights::find_whole(std::string_view place) const {
  auto finding = find(place);
  if (!has_exceptions_) return finding;
  const auto& top = nodes_[0];
  if (const auto found = top.exact.find(place); found != top.exact.end()) collect_all(found->second, marks_);
  if (top.any != 0) collect_all(top.any, marks_);
  for (const auto& [glob, child] : top.globs) {
    if (base::glob_matches(glob, place)) collect_all(child, marks_);
  }
  each_rule([&](const Mark* first, const Mark* last) {
    if (last[-1].except) judge(first, last, finding);
  });
  finding.granted.remove(finding.denied);
  return finding;
}

/// The marks of a node and of all below it.
void MemberRights::collect_all(std::uint32_t at, Marks& marks) const {
  const auto& node = nodes_[at];
  for (const auto* some : {&node.here, &node.rest}) marks.insert(marks.end(), some->begin(), some->end());
  if (node.any != 0) collect_all(node.any, marks);
  for (const auto& one : node.exact) collect_all(one.second, marks);
  for (const auto& one : node.globs) collect_all(one.second, marks);
}

bool MemberRights::sees_all() const {
  if (has_exceptions_) return false;
  RightSet granted;
  for (const auto& mark : nodes_[0].rest) {
    const auto& rule = rules_[mark.rule];
    if (rule.may.has(Right::kRead)) granted.add(only(Right::kRead));
    if (rule.may.has(Right::kDemand) && rule.interval == Duration(0)) granted.add(only(Right::kDemand));
  }
  return granted.has(Right::kRead) && granted.has(Right::kDemand);
}

}  // namespace rubicon::trust::rights
