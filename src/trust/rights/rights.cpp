#include "trust/rights/rights.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <tuple>

#include "base/glob.h"
#include "base/text.h"

namespace rubicon::trust::rights {

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

bool Rights::Before::is_before(const Member& a, const Member& b) {
  const auto one = std::tie(a.name, a.roles), other = std::tie(b.name, b.roles);
  if (one != other) return one < other;
  return std::lexicographical_compare(a.ids.begin(), a.ids.end(), b.ids.begin(), b.ids.end(),
                                      [](const tuples::IdRange& x, const tuples::IdRange& y) {
                                        return std::tie(x.first, x.last) < std::tie(y.first, y.last);
                                      });
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

}  // namespace rubicon::trust::rights
