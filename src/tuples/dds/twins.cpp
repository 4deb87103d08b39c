#include "tuples/dds/twins.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <random>

namespace rubicon::tuples::dds {

namespace {

/// Nobody can know it who was not asked.
std::uint64_t drawn_number() {
  static std::random_device dice;
  return static_cast<std::uint64_t>(dice()) << 32U | dice();
}

/// What may wait for one that takes nothing: it is asked again anyway.
constexpr std::size_t kMostWaiting = 256;

std::string time_text(std::uint64_t incarnation) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(static_cast<std::time_t>(incarnation / 1'000'000)));
}

}  // namespace

void Twins::begin(std::uint64_t own_incarnation) {
  timer_.cancel();
  all_.clear();
  own_ = own_incarnation;
  is_displaced_ = false;
}

Duration Twins::pause() const {
  return std::clamp<Duration>(lease_ / 4, std::chrono::milliseconds(100), std::chrono::seconds(1));
}

void Twins::seen(std::uint64_t incarnation, const Participant& who) {
  if (incarnation == own_ || all_.contains(incarnation) || !make_room(who)) return;
  auto& twin = all_[incarnation];
  twin.participant = who;
  twin.since = scheduler_.now();
  twin.question = drawn_number();
  if (incarnation < own_) look();
}

/// So that who invents starts does not hide a real one.
bool Twins::make_room(const Participant& who) {
  std::erase_if(all_, [&who](const auto& one) { return one.second.participant == who; });
  if (all_.size() < kMost) return true;
  auto longest = all_.end();
  for (auto one = all_.begin(); one != all_.end(); ++one) {
    if (one->second.answered) continue;
    if (longest == all_.end() || one->second.since < longest->second.since) longest = one;
  }
  if (longest == all_.end()) return false;
  all_.erase(longest);
  return true;
}

void Twins::gone(std::uint64_t incarnation) {
  all_.erase(incarnation);
}

/// Asks those that started earlier, for as long as they show themselves: a torn cable may be mended at any time.
void Twins::look() {
  bool go_on = false;
  for (auto& [incarnation, twin] : all_) {
    if (incarnation < own_) go_on |= look_at(incarnation, twin);
  }
  if (go_on) timer_ = scheduler_.after(pause(), [this] { look(); });
}

/// False: there is nothing more to find out.
bool Twins::look_at(std::uint64_t incarnation, Twin& twin) {
  if (twin.answered && scheduler_.now() - twin.since >= lease_) {
    if (!std::exchange(is_displaced_, true)) scheduler_.post(calls_.displaced);
    return false;
  }
  if (twin.answered) return true;
  if (++twin.asked == kPatience) {
    log_.warning(fmt::format(
        "something shows itself as component {}, started at {}, but does not answer: ignored, this one stays",
        number(self_), time_text(incarnation)));
  }
  tell(incarnation, twin, {false, twin.question});
  return true;
}

void Twins::tell(std::uint64_t incarnation, Twin& twin, const IdentityCheck& check) {
  if (!twin.channel) {
    auto channel = calls_.make_channel(incarnation);
    if (!channel) return log_.warning(channel.error().text);
    twin.channel = std::move(*channel);
  }
  if (twin.channel->waiting() < kMostWaiting) twin.channel->add(check);
  twin.channel->flush(scheduler_.now());  // what does not get through is asked again
}

void Twins::frame(std::uint64_t incarnation, ByteView content) {
  if (!all_.contains(incarnation)) return;
  reading_from_ = incarnation;
  std::ignore = read_frame(content, self_, self_, *this);
}

void Twins::on_identity_check(const IdentityCheck& check) {
  auto& twin = all_.at(reading_from_);
  if (!check.is_answer) return tell(reading_from_, twin, {true, check.number});
  twin.answered |= check.number == twin.question && twin.asked > 0;
}

}  // namespace rubicon::tuples::dds
