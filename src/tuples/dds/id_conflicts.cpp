#include "tuples/dds/id_conflicts.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>

#include "base/clocks.h"

namespace rubicon::tuples::dds {

namespace {

/// Unpredictable, so that only the receiver of the question can answer it.
std::uint64_t random_number() {
  static std::random_device source;
  return static_cast<std::uint64_t>(source()) << 32U | source();
}

/// Bytes that may wait for a rival that accepts nothing; the question is repeated anyway.
constexpr std::size_t kMaxWaitingChecks = 256;

std::string time_text(std::uint64_t incarnation) {
  return base::utc_text(WallTime(std::chrono::microseconds(incarnation)), "%Y-%m-%dT%H:%M:%SZ");
}

}  // namespace

void IdConflicts::begin(std::uint64_t own_incarnation) {
  timer_.cancel();
  all_.clear();
  own_ = own_incarnation;
  is_displaced_ = false;
}

Duration IdConflicts::pause() const {
  return std::clamp<Duration>(lease_ / 4, std::chrono::milliseconds(100), std::chrono::seconds(1));
}

void IdConflicts::seen(std::uint64_t incarnation, const Participant& who) {
  if (incarnation == own_ || all_.contains(incarnation) || !make_room(who)) return;
  auto& rival = all_[incarnation];
  rival.participant = who;
  rival.since = scheduler_.now();
  rival.question = random_number();
  if (incarnation < own_) ask_rivals();
}

/// Keeps a participant that invents starts from displacing real rivals.
bool IdConflicts::make_room(const Participant& who) {
  std::erase_if(all_, [&who](const auto& one) { return one.second.participant == who; });
  if (all_.size() < kMax) return true;
  auto longest = all_.end();
  for (auto one = all_.begin(); one != all_.end(); ++one) {
    if (one->second.answered) continue;
    if (longest == all_.end() || one->second.since < longest->second.since) longest = one;
  }
  if (longest == all_.end()) return false;
  all_.erase(longest);
  return true;
}

void IdConflicts::gone(std::uint64_t incarnation) {
  all_.erase(incarnation);
}

/// Asks the earlier starts for as long as they are present: a broken connection may be repaired at any time.
void IdConflicts::ask_rivals() {
  bool again = false;
  for (auto& [incarnation, rival] : all_) {
    if (incarnation < own_) again |= ask(incarnation, rival);
  }
  if (again) timer_ = scheduler_.after(pause(), [this] { ask_rivals(); });
}

/// False: the question is settled.
bool IdConflicts::ask(std::uint64_t incarnation, Rival& rival) {
  if (rival.answered && scheduler_.now() - rival.since >= lease_) {
    if (!std::exchange(is_displaced_, true)) scheduler_.post(callbacks_.displaced);
    return false;
  }
  if (rival.answered) return true;
  if (++rival.asked == kUnansweredQuestions) {
    log_.warning(fmt::format(
        "another presence of component {}, started at {}, does not answer: ignored, this process keeps the id",
        number(self_), time_text(incarnation)));
  }
  send(incarnation, rival, {false, rival.question});
  return true;
}

void IdConflicts::send(std::uint64_t incarnation, Rival& rival, const distant::IdentityCheck& check) {
  if (!rival.channel) {
    auto channel = callbacks_.make_channel(incarnation);
    if (!channel) return log_.warning(channel.error().text);
    rival.channel = std::move(*channel);
  }
  if (rival.channel->waiting() < kMaxWaitingChecks) rival.channel->add(check);
  rival.channel->flush(scheduler_.now());  // lost questions are repeated
}

void IdConflicts::on_frame(std::uint64_t incarnation, ByteView content) {
  if (!all_.contains(incarnation)) return;
  reading_from_ = incarnation;
  std::ignore = distant::read_frame(content, self_, self_, *this);
}

void IdConflicts::on_identity_check(const distant::IdentityCheck& check) {
  auto& rival = all_.at(reading_from_);
  if (!check.is_answer && !callbacks_.answers) return;
  if (!check.is_answer) return send(reading_from_, rival, {true, check.number});
  rival.answered |= check.number == rival.question && rival.asked > 0;
}

}  // namespace rubicon::tuples::dds
