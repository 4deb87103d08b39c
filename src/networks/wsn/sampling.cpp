#include "networks/wsn/sampling.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "motes/mote_records.h"

namespace rubicon::networks::wsn {

namespace {

constexpr std::uint16_t kEverything = 0xffff;
constexpr std::int64_t kLongestTicks = 65535;
/// The radio carries some 90 messages a second; period 0 was never tried (wsn.md 2, 9.4).
constexpr std::int64_t kShortestTicks = 51;
/// A mote that does not do as told is told again no more often than this.
constexpr Duration kPause = std::chrono::seconds(5);
constexpr Duration kLongestPause = std::chrono::minutes(1);
/// After the start, until subscribers had the time to find the island.
constexpr Duration kGrace = std::chrono::seconds(10);
constexpr Duration kOthers = std::chrono::hours(1);
constexpr std::size_t kCalmedAtATime = 8;
constexpr Duration kTimeToLive = std::chrono::seconds(30);

}  // namespace

std::uint16_t ticks_of(std::chrono::milliseconds period) {
  constexpr std::int64_t kMost = kLongestTicks * 1000 / 1024;
  const std::int64_t bounded = std::clamp<std::int64_t>(period.count(), 0, kMost + 1);
  return static_cast<std::uint16_t>(std::clamp((bounded * 1024 + 500) / 1000, kShortestTicks, kLongestTicks));
}

Sampling::Sampling(Scheduler& scheduler, MoteRequests& requests, SamplingOptions options, ToldCall told)
    : scheduler_(scheduler), requests_(requests), options_(options), told_(std::move(told)), began_(scheduler.now()) {}

bool Sampling::settled(const Mote& mote) const {
  if (mote.told) return *mote.told == mote.wish;
  return mote.wish.mask == 0 && !mote.reports;
}

/// A mote that reports for nobody may report for subscribers who are about to find us again, or for another program;
/// and calming many must not keep the commands of others from their lane.
bool Sampling::may_tell(const Mote& mote) const {
  const auto now = scheduler_.now();
  if (mote.asked || now < mote.tried + kPause) return false;
  if (mote.wish.mask != 0) return true;
  return now >= std::max(mote.others_until, all_others_until_) && now >= began_ + kGrace && calming_ < kCalmedAtATime;
}

Result<void> Sampling::want(std::uint16_t address, Reads reads) {
  Mote& mote = motes_[address];
  const bool repeated = mote.wish == reads;
  mote.wish = reads;
  mote.failures = 0;
  if (mote.asked) return {};  // its end looks at the wish
  // Who asks for the same once more misses it.
  if (settled(mote) && (!repeated || reads.mask == 0)) return {};
  auto told = tell(address, mote);
  if (!told) tell_later(address, mote);
  return told;
}

Result<void> Sampling::tell(std::uint16_t address, Mote& mote) {
  MoteRequest request;
  request.header.destination_island = request.header.source_island = options_.island;
  request.header.destination_mote = address;
  request.header.source_mote = motes::kBaseMote;
  request.header.reliable = 1;
  request.header.transport = motes::kTransportConnectionless;
  request.header.application = options_.read_updates ? motes::kApplicationControl : motes::kApplicationMockup;
  request.record = options_.read_updates
                       ? motes::encode_record(motes::ReadUpdates{mote.wish.ticks, mote.wish.mask})
                       : motes::encode_record(motes::PeriodicCommand{mote.wish.mask, mote.wish.ticks});
  request.lane = Lane::kSampling;
  request.time_to_live = kTimeToLive;
  request.done = [this, address](Delivered how) { ended(address, how); };
  mote.tried = scheduler_.now();
  auto sent = requests_.send(std::move(request));
  if (!sent) return sent;
  mote.asked = mote.wish;
  if (mote.wish.mask == 0) ++calming_;
  // Until it answers, only what it reads either way is fresh.
  mote.told.reset();
  mote.sure = static_cast<std::uint16_t>(mote.wish.mask & mote.sure.value_or(kEverything));
  told_(address, mote.sure, false);
  return {};
}

void Sampling::ended(std::uint16_t address, Delivered how) {
  Mote& mote = motes_[address];
  const auto asked = std::exchange(mote.asked, std::nullopt);
  if (asked && asked->mask == 0) --calming_;
  if (!asked) return;
  if (how != Delivered::kAcknowledged) return tell_later(address, mote);
  mote.failures = 0;
  if (std::exchange(mote.overruled, false)) {
    mote.sure.reset();
    return told_(address, std::nullopt, false);
  }
  mote.told = asked;
  mote.sure = asked->mask;
  mote.reports = true;
  told_(address, asked->mask, true);
  if (!settled(mote)) std::ignore = tell(address, mote);
}

/// Somebody waits for its readings: a mote that does not answer is told again after 5 s, then ever less often.
void Sampling::tell_later(std::uint16_t address, Mote& mote) {
  if (mote.wish.mask == 0 || mote.again.pending()) return;
  const auto pause = std::min<Duration>(kPause * (1U << std::min(mote.failures++, 4U)), kLongestPause);
  mote.again = scheduler_.after(pause, [this, address] {
    Mote& late = motes_[address];
    if (late.asked || settled(late) || late.wish.mask == 0) return;
    if (!tell(address, late)) tell_later(address, late);
  });
}

void Sampling::joined(std::uint16_t address) {
  Mote& mote = motes_[address];
  mote.reports = false;
  mote.others_until = {};
  mote.sure.reset();
  mote.failures = 0;
  if (std::exchange(mote.told, std::nullopt)) told_(address, std::nullopt, false);
  if (mote.wish.mask != 0 && !mote.asked && !tell(address, mote)) tell_later(address, mote);
}

void Sampling::heard(std::uint16_t address, bool reported) {
  Mote& mote = motes_[address];
  mote.reports = mote.reports || reported;
  if (!settled(mote) && may_tell(mote)) std::ignore = tell(address, mote);
}

void Sampling::overruled(std::uint16_t address) {
  const auto until = scheduler_.now() + kOthers;
  if (address == motes::kBroadcast) {
    all_others_until_ = until;
    for (auto& [one, mote] : motes_) overrule(one, mote);
    return;
  }
  Mote& mote = motes_[address];
  mote.others_until = until;
  overrule(address, mote);
}

void Sampling::overrule(std::uint16_t address, Mote& mote) {
  mote.overruled = mote.asked.has_value();
  mote.sure.reset();
  mote.tried = scheduler_.now();
  mote.told.reset();
  told_(address, std::nullopt, false);
}

}  // namespace rubicon::networks::wsn
