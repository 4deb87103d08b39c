#include "tuples/dds/moves.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

namespace rubicon::tuples::dds {

namespace {

using transport::Interface;

/// From the first sign of a change: a new address follows the loss of the former one.
constexpr Duration kSettle = std::chrono::milliseconds(500);
/// The deletion of the former domain may take this long; then the new one is made beside it.
constexpr Duration kLongestFarewell = std::chrono::seconds(1);
constexpr Duration kTryAgain = std::chrono::seconds(1);

const Interface* find_in(const std::vector<Interface>& present, const std::string& name) {
  const auto found = std::find_if(present.begin(), present.end(), [&](const auto& one) { return one.name == name; });
  return found == present.end() ? nullptr : &*found;
}

/// Of `names`, those that DDS can use.
std::vector<Interface> usable(const std::vector<std::string>& names, const std::vector<Interface>& present) {
  std::vector<Interface> all;
  for (const auto& name : names) {
    const auto* one = find_in(present, name);
    if (one && one->is_up && !one->address.empty()) all.push_back(*one);
  }
  return all;
}

/// Whether a domain that uses the one can go on with the other. A link that is lost and comes back changes nothing.
bool is_same(const Interface& one, const Interface& other) {
  return one.index == other.index && one.address == other.address;
}

std::string text_of(const std::vector<Interface>& all) {
  std::vector<std::string> texts;
  for (const auto& one : all) texts.push_back(fmt::format("{} ({})", one.name, one.address));
  return fmt::format("{}", fmt::join(texts, ", "));
}

std::string lack_of(const Interface* one) {
  if (!one) return "is not there";
  if (!one->is_up) return "is down";
  if (one->address.empty()) return "has no IPv4 address";
  return one->has_link ? "" : "has no link (cable or Wi-Fi)";
}

}  // namespace

Moves::Moves(std::vector<std::string> names, Scheduler& scheduler, DdsEcology::Post post, Log log, Calls calls)
    : names_(std::move(names)),
      scheduler_(scheduler),
      post_(std::move(post)),
      log_(log),
      limited_log_(std::move(log), scheduler),
      calls_(std::move(calls)),
      look_(scheduler, [this] { look(); }),
      arrival_(scheduler, [this] { arrive(); }) {}

void Moves::follow(const transport::WatchInterfaces& watch) {
  auto opened = watch([this] { look_.advance_to(scheduler_.now() + kSettle); });
  if (!opened) return log_.warning(opened.error().text + ": a changed address is not noticed");
  watch_ = std::move(*opened);
  look_.set(kSettle);  // what changed between the start and now
}

std::vector<std::string> Moves::take(const std::vector<Interface>& present) {
  used_ = usable(names_, present);
  std::vector<std::string> names;
  for (const auto& one : used_) names.push_back(one.name);
  return names;
}

void Moves::look() {
  const auto present = watch_->interfaces();
  report(present);
  const auto now = usable(names_, present);
  const bool same = std::equal(now.begin(), now.end(), used_.begin(), used_.end(), is_same);
  if (now.empty() || same || under_way()) return;
  drop_deleted();
  if (former_.size() >= kMaxFormer) {
    limited_log_.error("former", "DDS does not delete its former domains: this process cannot follow its addresses");
    return look_.set(kTryAgain);
  }
  ++news_.changes;
  news_.changed = scheduler_.wall_now();
  log_.warning(fmt::format("addresses changed: {}; before {}: the components of this process enter the ecology again",
                           text_of(now), used_.empty() ? "none" : text_of(used_)));
  move();
}

/// Each lack once, and its end.
void Moves::report(const std::vector<Interface>& present) {
  std::map<std::string, InterfaceNews::State> states;
  for (const auto& name : names_) {
    const auto* one = find_in(present, name);
    const auto& state = states[name] = {one ? one->address : "", lack_of(one)};
    const auto before = news_.interfaces.find(name);
    const auto lacked = before == news_.interfaces.end() ? std::string() : before->second.lack;
    if (state.lack == lacked) continue;
    if (state.lack.empty()) {
      log_.info(fmt::format("interface {} ({}) is back", name, state.address));
    } else {
      log_.warning(fmt::format("interface {} {}: it reaches no other host", name, state.lack));
    }
  }
  news_.interfaces = std::move(states);
}

void Moves::move() {
  auto remains = calls_.leave();
  if (!remains.domain) return arrive();
  former_.push_back(std::make_unique<FormerDomain>(std::move(remains), scheduler_, post_, [this] {
    drop_deleted();
    if (under_way()) arrive();
  }));
  arrival_.set(kLongestFarewell);
}

void Moves::arrive() {
  arrival_.clear();
  if (const auto done = calls_.come_back(); !done) {
    limited_log_.error("outside", done.error().text);
    return arrival_.set(kTryAgain);
  }
  log_.info("this process is in the ecology again: " + text_of(used_));
  look_.advance_to(scheduler_.now());  // what changed meanwhile
}

void Moves::drop_deleted() {
  std::erase_if(former_, [](const auto& one) { return one->is_deleted(); });
}

}  // namespace rubicon::tuples::dds
