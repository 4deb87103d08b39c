#include "rights/rights.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <tuple>

#include "base/compare_text.h"
#include "base/text.h"
#include "model/type_names.h"
#include "rubicon/address.hpp"
#include "rubicon/key.hpp"
#include "rubicon/tuple.hpp"

namespace rubicon::rights {

namespace {

constexpr std::string_view kWords[] = {"read", "demand", "set", "approve", "send"};
constexpr std::size_t kMaxName = 64;  // of a certificate (RFC 5280, ub-common-name)
constexpr std::uint32_t kMaxIsland = 65532;

bool is_of_parts(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
}

bool is_island(std::string_view text) {
  const auto id = base::parse_number<std::uint32_t>(text.substr(kIsland.size()));
  return id && *id >= 1 && *id <= kMaxIsland;
}

bool is_part(std::string_view part, bool last) {
  if (part == "**") return last;
  const auto good = [](char c) { return is_of_parts(c) || c == '*'; };
  return !part.empty() && std::all_of(part.begin(), part.end(), good) && part.find("**") == part.npos;
}

}  // namespace

std::string_view to_string(Right right) {
  return kWords[static_cast<std::size_t>(right)];
}

std::optional<Right> right_of(std::string_view word) {
  const auto* const found = std::find(std::begin(kWords), std::end(kWords), word);
  return found == std::end(kWords) ? std::nullopt : std::optional(kRights[found - std::begin(kWords)]);
}

RightSet RightSet::all() {
  RightSet set;
  for (const auto right : kRights) set.add(right);
  return set;
}

Result<void> check_who(std::string_view who) {
  const auto good = [](char c) { return is_of_parts(c) || c == '.' || c == '@'; };
  auto name = who;
  for (const auto source : {kUser, kGroup, kMember, kRole, kToken, kBridge}) {
    if (name.starts_with(source)) name.remove_prefix(source.size());
    if (name.size() < who.size()) break;
  }
  const auto longest = name.find('@') == name.npos ? kMaxName : 2 * kMaxName + 1;  // of two: who vouches stands behind
  const bool named = !name.empty() && name.size() <= longest && std::all_of(name.begin(), name.end(), good);
  if (who.starts_with(kIsland) ? is_island(who) : named) return {};
  return fail(
      ErrorCode::kInvalid,
      fmt::format("{}: expected the name or the role of a member, user:<name>, group:<name>, member:<name>, "
                  "role:<name>, token:<name>@<member>, bridge:<name>, everybody, lan, peis, or island:<1 to {}>",
                  model::quoted(who), kMaxIsland));
}

Result<void> check_vouched(std::string_view names) {
  const auto good = [](char c) { return is_of_parts(c) || c == '.' || c == '@' || c == ':' || c == '*'; };
  if (!names.empty() && names.size() <= tuples::kMaxAsker && std::all_of(names.begin(), names.end(), good)) return {};
  return fail(ErrorCode::kInvalid, fmt::format("{}: expected names with their source, such as user:*, member:desk or "
                                               "token:*",
                                               model::quoted(names)));
}

Result<void> check_rule_key(std::string_view pattern) {
  if (pattern.starts_with(kIsland) && is_island(pattern)) return {};
  auto rest = pattern;
  std::size_t parts = 0;
  bool good = pattern.size() <= model::kMaxKeyLength;
  for (bool last = false; good && !last; ++parts) {
    const auto dot = rest.find('.');
    last = dot == rest.npos;
    good = is_part(rest.substr(0, dot), last);
    if (!last) rest.remove_prefix(dot + 1);
  }
  if (good && parts <= model::kMaxKeyParts) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("{}: expected parts of A-Z a-z 0-9 _ - joined by dots, with * for any text in a part and ** "
                          "for all that follow, or island:<id>",
                          model::quoted(pattern)));
}

std::string kept_key(std::string_view key) {
  constexpr auto kDotsOfProperty = 4;  // proxy.<network>.<device>.property.<name>
  return std::count(key.begin(), key.end(), '.') >= kDotsOfProperty ? model::without_alias(key) : std::string(key);
}

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

namespace {

using tuples::Member;

constexpr const char* kAdmin = "admin";
constexpr std::string_view kOwn = "own";  // as gateway/message_rights has it

bool is_named(const Member& who, std::string_view word) {
  if (who.is_unproven()) return word == std::string_view(who.name).substr(0, who.name.find('@'));
  if (word == kEverybody || word == who.name) return true;
  if (word.starts_with(kMember)) return word.substr(kMember.size()) == who.name;
  if (word.starts_with(kRole)) return who.has_role(word.substr(kRole.size()));
  if (!word.starts_with(kIsland)) return who.has_role(word);
  const auto id = base::parse_number<std::uint32_t>(word.substr(kIsland.size()));
  return id && who.may_use(OwnerId(*id));
}

/// A message to a network, and to none of its devices, is raw access to its line.
bool is_whole_network(Right right, std::string_view where) {
  return right == Right::kSend && where != kOwn && where.find('.') == where.npos && !where.starts_with(kIsland);
}

std::string text_of(const Decision& decision, const std::vector<Rule>& rules) {
  if (!decision.rule) return "no rule allows it";
  const auto& place = rules[*decision.rule].place;
  return fmt::format("rule {}{} {} it", *decision.rule + 1, place.empty() ? "" : fmt::format(" ({})", place),
                     decision.allowed ? "allows" : "denies");
}

}  // namespace

Rights::Rights() : rules_{{.who = {kAdmin}, .may = RightSet::all()}}, only_admins_(true) {}

Rights::Rights(std::vector<Rule> rules) : rules_(std::move(rules)) {
  for (auto& rule : rules_) {
    for (auto* keys : {&rule.keys, &rule.except}) std::transform(keys->begin(), keys->end(), keys->begin(), kept_key);
  }
}

bool Rights::concerns(const Rule& rule, const Member& who) const {
  if (only_admins_) return !who.is_unproven() && who.has_role(kAdmin);
  return std::any_of(rule.who.begin(), rule.who.end(), [&](const auto& word) { return is_named(who, word); });
}

/// Rules name ids of islands only; each run of a tool has another id.
bool Rights::Before::is_before(const Member& a, const Member& b) {
  const auto one = std::tie(a.name, a.roles), other = std::tie(b.name, b.roles);
  if (one != other) return one < other;
  const auto has_islands = [](const tuples::IdRange& ids) { return ids.first <= model::kMaxIslandId; };
  for (auto x = a.ids.begin(), y = b.ids.begin();; ++x, ++y) {
    x = std::find_if(x, a.ids.end(), has_islands);
    y = std::find_if(y, b.ids.end(), has_islands);
    if (x == a.ids.end() || y == b.ids.end()) return x == a.ids.end() && y != b.ids.end();
    const auto left = std::tie(x->first, x->last), right = std::tie(y->first, y->last);
    if (left != right) return left < right;
  }
}

const MemberRights& Rights::of(const Member& who) const {
  if (const auto found = by_member_.find(who); found != by_member_.end()) {
    kept_.splice(kept_.begin(), kept_, *found);
    return kept_.front().rights;
  }
  ++compiled_;
  auto& kept = kept_.emplace_front(Kept{who});
  by_member_.insert(kept_.begin());
  for (std::size_t i = 0; i < rules_.size(); ++i) {
    if (rules_[i].names.empty() && concerns(rules_[i], who)) kept.rights.add(rules_[i], i);
  }
  if (kept_.size() > kMaxKept) {
    by_member_.erase(std::prev(kept_.end()));
    kept_.pop_back();
  }
  return kept.rights;
}

Decision Rights::decide(const Member& who, Right right, std::string_view key) const {
  const auto& compiled = of(who);
  const auto finding = is_whole_network(right, key) ? compiled.find_whole(key) : compiled.find(key);
  Decision decision{finding.granted.has(right), {}, {}};
  const auto by = finding.by[static_cast<std::size_t>(right)];
  if (by != MemberRights::kNone) decision.rule = by;
  decision.text = text_of(decision, rules_);
  if (!decision.allowed && is_whole_network(right, key) && compiled.find(key).granted.has(right))
    decision.text += fmt::format(": what goes to {} reaches the devices that it excepts too", key);
  return decision;
}

tuples::Access Rights::access(const Member& who, std::string_view key) const {
  const auto finding = of(who).find(key);
  return {finding.granted.has(Right::kRead), finding.granted.has(Right::kDemand), finding.interval};
}

bool Rights::may_vouch(const Member& who, std::string_view name) const {
  return check_vouched(name) && name.find('*') == name.npos &&
         std::any_of(rules_.begin(), rules_.end(), [&](const Rule& rule) {
           const auto names_it = [&](const auto& pattern) { return base::glob_matches(pattern, name); };
           return std::any_of(rule.names.begin(), rule.names.end(), names_it) && concerns(rule, who);
         });
}

bool Rights::sees_all(const Member& who) const {
  return of(who).sees_all();
}

}  // namespace rubicon::rights
