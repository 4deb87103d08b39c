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
constexpr Duration kTimeToLive = std::chrono::seconds(30);

}  // namespace

std::uint16_t ticks_of(std::chrono::milliseconds period) {
  constexpr std::int64_t kMost = kLongestTicks * 1000 / 1024;
  const std::int64_t bounded = std::clamp<std::int64_t>(period.count(), 0, kMost + 1);
  return static_cast<std::uint16_t>(std::clamp((bounded * 1024 + 500) / 1000, kShortestTicks, kLongestTicks));
}

Sampling::Sampling(Scheduler& scheduler, MoteRequests& requests, SamplingOptions options, ToldCall told)
    : scheduler_(scheduler), requests_(requests), options_(options), told_(std::move(told)) {}

bool Sampling::settled(const Mote& mote) const {
  if (mote.told) return *mote.told == mote.wish;
  return mote.wish.mask == 0 && (!mote.reports || mote.others);
}

Result<void> Sampling::want(std::uint16_t address, Reads reads) {
  Mote& mote = motes_[address];
  const bool repeated = mote.wish == reads;
  mote.wish = reads;
  mote.others = mote.others && reads.mask == 0;
  if (mote.asked) return {};  // its end looks at the wish
  // Who asks for the same once more misses it.
  if (settled(mote) && (!repeated || reads.mask == 0)) return {};
  return tell(address, mote);
}

Result<void> Sampling::tell(std::uint16_t address, Mote& mote) {
  MoteRequest request;
  request.header = {options_.island,
                    address,
                    options_.island,
                    motes::kBaseMote,
                    1,
                    0,
                    0,
                    motes::kTransportConnectionless,
                    options_.read_updates ? motes::kApplicationControl : motes::kApplicationMockup,
                    {}};
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
  // Until it answers, only what it reads either way is fresh.
  const auto before = std::exchange(mote.told, std::nullopt);
  told_(address, static_cast<std::uint16_t>(mote.wish.mask & (before ? before->mask : kEverything)), false);
  return {};
}

void Sampling::ended(std::uint16_t address, Delivered how) {
  Mote& mote = motes_[address];
  const auto asked = std::exchange(mote.asked, std::nullopt);
  if (how == Delivered::kAcknowledged && asked) {
    mote.told = asked;
    mote.reports = true;
    mote.others = false;
    told_(address, asked->mask, true);
  }
  if (how == Delivered::kAcknowledged && !settled(mote)) std::ignore = tell(address, mote);
}

void Sampling::joined(std::uint16_t address) {
  Mote& mote = motes_[address];
  mote.reports = mote.others = false;
  if (std::exchange(mote.told, std::nullopt)) told_(address, std::nullopt, false);
  if (mote.wish.mask != 0 && !mote.asked) std::ignore = tell(address, mote);
}

void Sampling::heard(std::uint16_t address, bool reported) {
  Mote& mote = motes_[address];
  mote.reports = mote.reports || reported;
  if (mote.asked || settled(mote) || scheduler_.now() < mote.tried + kPause) return;
  std::ignore = tell(address, mote);
}

void Sampling::overruled(std::uint16_t address) {
  Mote& mote = motes_[address];
  mote.others = true;
  if (std::exchange(mote.told, std::nullopt)) told_(address, std::nullopt, false);
}

}  // namespace rubicon::networks::wsn
