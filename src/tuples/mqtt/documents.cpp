#include "tuples/mqtt/documents.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>

namespace rubicon::tuples::mqtt {

Documents::Documents(const Topics& topics, std::string user, UserRealm& realm, Scheduler& scheduler,
                     base::LimitedLog& log, Callbacks calls)
    : topics_(topics),
      user_(std::move(user)),
      realm_(realm),
      scheduler_(scheduler),
      log_(log),
      callbacks_(std::move(calls)),
      show_(scheduler, [this] { show(); }),
      next_(scheduler, [this] { check_waiting(); }),
      changes_(realm.watch([this] { changed(); })) {}

void Documents::connected() {
  for (auto& [user, shown] : users_) {
    shown.newest = shown.old = false;
    shown.next = {};  // who was shut out meanwhile is known at once
  }
  callbacks_.subscribe(topics_.document_filter());
}

void Documents::read() {
  read_ = true;
  review();
}

void Documents::cut() {
  read_ = false;
  show_.clear();
}

bool Documents::received(std::string_view topic, std::string_view payload) {
  const auto user = topics_.user_of_document(topic);
  if (!user) return false;
  auto known = users_.find(*user);
  if (known == users_.end()) {
    if (payload.empty()) return true;
    if (users_.size() >= kMaxUsers && !realm_.member(*user)) return refuse(*user, "there are too many users"), true;
    known = users_.try_emplace(*user).first;
  }
  look_at(*user, known->second, payload);
  review();
  return true;
}

void Documents::look_at(const std::string& user, Shown& shown, std::string_view document) {
  waiting_ -= std::exchange(shown.waiting, {}).size();  // the last one that a user shows counts
  shown.newest = document == realm_.document();
  shown.old = false;
  if (shown.newest) spread_ = kSpread;
  if (document.empty() || shown.newest) return;
  if (document.size() > UserRealm::kMaxDocument) return refuse(user, fmt::format("it has {} bytes", document.size()));
  if (scheduler_.now() < shown.next) return wait(user, shown, document);
  if (!may_check(user)) return refuse(user, "too many are shown at once");
  check(user, shown, document);
}

/// Limits only users outside the realm: made-up users do not delay members.
bool Documents::may_check(const std::string& user) {
  if (realm_.member(user)) return true;
  const auto now = scheduler_.now();
  if (now - window_ >= kWindow) {
    window_ = now;
    checks_ = 0;
  }
  return checks_++ < kMaxChecks;
}

void Documents::wait(const std::string& user, Shown& shown, std::string_view document) {
  if (waiting_ + document.size() > kMaxWaiting) return refuse(user, "too many wait to be checked");
  waiting_ += document.size();
  shown.waiting = document;
  next_.advance_to(shown.next);
}

void Documents::check_waiting() {
  const auto now = scheduler_.now();
  std::vector<std::string> due;
  for (const auto& [user, shown] : users_) {
    if (shown.waiting.empty()) continue;
    if (shown.next > now) {
      next_.advance_to(shown.next);
    } else {
      due.push_back(user);
    }
  }
  for (const auto& user : due) {
    auto& shown = users_.at(user);
    look_at(user, shown, std::string(shown.waiting));
  }
  review();
}

/// If the document is newer than ours, what all other users show is old from now on.
void Documents::check(const std::string& user, Shown& shown, std::string_view document) {
  shown.next = scheduler_.now() + kEach;
  taking_ = true;
  const auto taken = realm_.take(document, user);
  taking_ = false;
  if (taken == UserRealm::Taken::kWrong) return refuse(user, "it is not signed by the authority of this realm");
  shown.newest = taken == UserRealm::Taken::kNewer;
  shown.old = !shown.newest;
  if (shown.old) return void(++counters_.old);
  spread_ = kSpread;
}

void Documents::refuse(const std::string& user, std::string_view why) {
  ++counters_.refused;
  log_.warning("document of " + user, fmt::format("the realm file that user {} shows is ignored: {}", user, why));
}

/// The realm has a newer document, from the disk or from a user; check() then marks that user's as the newest.
void Documents::changed() {
  for (auto& [user, shown] : users_) shown.old |= std::exchange(shown.newest, false);
  spread_ = {};
  show_.clear();
  if (!taking_) review();
}

/// The first member that shows the newest document; nullptr: no member does.
const std::string* Documents::first_who_shows() const {
  const auto found = std::find_if(users_.begin(), users_.end(),
                                  [this](const auto& one) { return one.second.newest && realm_.member(one.first); });
  return found == users_.end() ? nullptr : &found->first;
}

/// If no member shows the newest document, this one will: at once if no user ever showed it, after a random pause if
/// the broker lost it, because many members notice that. If several members show it, only the first one keeps it.
void Documents::review() {
  if (!read_ || user_ == kAnonymous) return;
  const auto* first = first_who_shows();
  if (!first) {
    if (show_.is_set()) return;
    static std::minstd_rand random{std::random_device()()};
    return show_.set(Duration(std::uniform_int_distribution<Duration::rep>(0, spread_.count())(random)));
  }
  show_.clear();
  const auto own = users_.find(user_);
  if (own == users_.end() || first == &own->first || !(own->second.old || own->second.newest)) return;
  own->second.old = own->second.newest = false;
  callbacks_.publish(topics_.document(user_), {});
}

void Documents::show() {
  callbacks_.publish(topics_.document(user_), realm_.document());
  show_.set(kShowAgain);
}

}  // namespace rubicon::tuples::mqtt
