#include "tuples/dds/moves.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <system_error>
#include <tuple>
#include <utility>

#include "wire.h"  // made from wire.idl

namespace rubicon::tuples::dds {

namespace {

constexpr Duration kReadPause = std::chrono::milliseconds(2);

}  // namespace

FormerDomain::FormerDomain(Remains remains, Scheduler& scheduler, DdsEcology::Post post, std::function<void()> deleted)
    : remains_(std::move(remains)),
      scheduler_(scheduler),
      deleted_(std::make_shared<std::function<void()>>(std::move(deleted))) {
  const auto remove = [domain = remains_.domain.get(), done = done_, post = std::move(post),
                       call = std::weak_ptr(deleted_)] {
    dds_delete(domain);
    *done = true;
    post([call] {
      if (const auto tell = call.lock()) (*tell)();
    });
  };
  try {
    thread_ = std::thread(remove);
    read_soon();
  } catch (const std::system_error&) {
    remove();  // the system has no thread to give
  }
}

FormerDomain::~FormerDomain() {
  while (!is_deleted()) {
    read();
    dds_sleepfor(DDS_MSECS(1));
  }
  if (thread_.joinable()) thread_.join();
}

void FormerDomain::read() {
  for (const auto reader : remains_.frame_readers)
    take<rubicon_wire_Frame>(reader, SIZE_MAX, [](const auto&, const auto&) {});
}

void FormerDomain::read_soon() {
  timer_ = scheduler_.after(kReadPause, [this] {
    if (is_deleted()) return;
    read();
    read_soon();
  });
}

namespace {

using transport::Interface;

/// From the first sign of a change: a new address follows the loss of the former one.
constexpr Duration kSettle = std::chrono::milliseconds(500);
/// The deletion of the former domain may take this long; then the new one is made beside it.
constexpr Duration kMaxFarewell = std::chrono::seconds(1);
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

Moves::Moves(std::vector<std::string> names, Scheduler& scheduler, DdsEcology::Post post, Log log, Callbacks calls)
    : names_(std::move(names)),
      scheduler_(scheduler),
      post_(std::move(post)),
      log_(log),
      limited_log_(std::move(log), scheduler),
      callbacks_(std::move(calls)),
      look_(scheduler, [this] { look(); }),
      arrival_(scheduler, [this] { arrive(); }),
      departure_(scheduler, [this] {
        if (under_way()) return;
        if (!may_move()) return departure_.set(kTryAgain);
        move();
      }) {}

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
  if (!may_move()) return look_.set(kTryAgain);
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

bool Moves::may_move() {
  drop_deleted();
  if (former_.size() < kMaxFormer) return true;
  limited_log_.error("former", "DDS does not delete its former domains: this process cannot enter another one");
  return false;
}

void Moves::move_anyway(Duration outside) {
  outside_ = std::max(outside_, outside);
  departure_.advance_to(scheduler_.now());
}

/// False: there is no domain. `deleted` is called in a turn of the loop.
bool Moves::delete_slowly(FormerDomain::Remains remains, std::function<void()> deleted) {
  if (!remains.domain) return false;
  former_.push_back(
      std::make_unique<FormerDomain>(std::move(remains), scheduler_, post_, [this, deleted = std::move(deleted)] {
        drop_deleted();
        deleted();
      }));
  return true;
}

void Moves::move() {
  const bool was_in = delete_slowly(callbacks_.leave(), [this] {
    if (under_way() && outside_ == Duration(0)) arrive();
  });
  arrival_.set(std::max(was_in ? kMaxFarewell : Duration(0), outside_));
}

void Moves::arrive() {
  arrival_.clear();
  outside_ = Duration(0);
  if (!may_move()) return arrival_.set(kTryAgain);
  if (const auto done = callbacks_.come_back(); !done) {
    limited_log_.error("outside", done.error().text);
    std::ignore = delete_slowly(callbacks_.leave(), [] {});
    return arrival_.set(kTryAgain);
  }
  log_.info("this process is in the ecology again: " + text_of(used_));
}

void Moves::drop_deleted() {
  std::erase_if(former_, [](const auto& one) { return one->is_deleted(); });
}

}  // namespace rubicon::tuples::dds
