#include "networks/wsn/sampling.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "motes/mote_records.h"

namespace rubicon::networks::wsn {

namespace {

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
/// A mote whose last report is older than two and a half periods and this may have been switched off and on unheard.
constexpr Duration kLateReport = std::chrono::seconds(1);
constexpr Duration kTimeToLive = std::chrono::seconds(30);

Duration span_of(std::uint16_t ticks) {
  return Duration(std::chrono::nanoseconds(std::int64_t{ticks} * 1'000'000'000 / 1024));
}

}  // namespace

std::uint16_t ticks_of(std::chrono::milliseconds period) {
  constexpr std::int64_t kMost = kLongestTicks * 1000 / 1024;
  const std::int64_t bounded = std::clamp<std::int64_t>(period.count(), 0, kMost + 1);
  return static_cast<std::uint16_t>(std::clamp((bounded * 1024 + 500) / 1000, kShortestTicks, kLongestTicks));
}

Sampling::Sampling(Scheduler& scheduler, MoteRequests& requests, SamplingOptions options, Calls calls)
    : scheduler_(scheduler),
      requests_(requests),
      options_(options),
      calls_(std::move(calls)),
      began_(scheduler.now()) {}

bool Sampling::settled(const Mote& mote) const {
  if (mote.told) return *mote.told == mote.wish;
  return mote.wish.mask == 0 && !mote.reports;
}

/// A mote that reports for nobody may report for subscribers who are about to find us again, or for another program;
/// and calming many must not keep the commands of others from their lane.
bool Sampling::may_tell(const Mote& mote) const {
  const auto now = scheduler_.now();
  if (closed_ || mote.asked || now < mote.tried + kPause) return false;
  if (mote.wish.mask != 0) return true;
  return now >= std::max(mote.others_until, all_others_until_) && now >= began_ + kGrace && calming_ < kCalmedAtATime;
}

Result<void> Sampling::want(std::uint16_t address, Reads reads) {
  if (closed_) return fail(ErrorCode::kUnreachable, "the island ends: its motes get the command to stop");
  Mote& mote = motes_[address];
  const bool repeated = mote.wish == reads;
  mote.wish = reads;
  mote.failures = 0;
  if (!repeated) mote.again.cancel();  // the pauses of the former wish are over
  if (mote.asked) return {};           // its end looks at the wish
  // Who asks for the same once more misses it.
  if (settled(mote) && (!repeated || reads.mask == 0)) return {};
  auto told = tell(address, mote);
  if (!told) tell_later(address, mote);
  return told;
}

bool Sampling::obeys(std::uint16_t address, const Reads& reads) const {
  const auto found = motes_.find(address);
  return found != motes_.end() && found->second.told == reads && found->second.wish == reads;
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
  request.lane = sink::Lane::kSampling;
  request.time_to_live = kTimeToLive;
  request.done = [this, address](DeliveryResult how) { ended(address, how); };
  mote.tried = scheduler_.now();
  auto sent = requests_.send(std::move(request));
  if (!sent) return sent;
  mote.asked = mote.wish;
  if (mote.wish.mask == 0) ++calming_;
  mote.woken = mote.woken || mote.wish.mask != 0;
  // Until it answers, only what it reads either way is fresh.
  forget_measurements_of_old(mote);
  mote.told.reset();
  mote.measured &= mote.wish.mask;
  // One that reads what nobody knows goes on with that until it is calmed; told to read, its next report may be the
  // first one for us.
  const bool unknown = !mote.reads && (mote.deaf || mote.wish.mask == 0);
  if (!unknown) mote.reads = static_cast<std::uint16_t>(mote.wish.mask & mote.reads.value_or(0));
  believe(address, mote);
  return {};
}

void Sampling::forget_measurements_of_old(Mote& mote) const {
  const auto patience = mote.told ? span_of(mote.told->ticks) * 5 / 2 + kLateReport : kLateReport;
  if (mote.reported + patience < scheduler_.now()) mote.measured = 0;
}

void Sampling::believe(std::uint16_t address, const Mote& mote) const {
  calls_.measures(address, mote.first ? mote.measured : mote.reads);
}

void Sampling::ended(std::uint16_t address, DeliveryResult how) {
  Mote& mote = motes_[address];
  const auto asked = std::exchange(mote.asked, std::nullopt);
  if (!asked) return;
  if (asked->mask == 0) --calming_;
  if (how == DeliveryResult::kAcknowledged) {
    acknowledged(address, mote, *asked);
  } else {
    not_acknowledged(address, mote, how);
  }
  if (closing_) stop_ended(address, mote, *asked, how);
}

void Sampling::acknowledged(std::uint16_t address, Mote& mote, const Reads& asked) {
  mote.failures = 0;
  mote.answers = true;
  mote.deaf = false;
  if (std::exchange(mote.overruled, false)) {  // which of the two commands came last is not known
    mote.reads.reset();
    mote.measured = 0;
    mote.first = true;
    return believe(address, mote);
  }
  mote.told = asked;
  mote.reads = asked.mask;
  mote.first = (asked.mask & ~mote.measured) != 0;
  mote.reports = true;
  if (asked.mask == 0) mote.woken = false;
  believe(address, mote);
  calls_.obeys(address, asked.mask);
  if (!settled(mote)) std::ignore = tell(address, mote);
}

/// A mote that never acknowledged anything does not hear us: what it reports somebody else asked for.
void Sampling::not_acknowledged(std::uint16_t address, Mote& mote, DeliveryResult how) {
  if (how == DeliveryResult::kNoAnswer && !mote.answers) {
    mote.deaf = true;
    mote.reads.reset();
    mote.first = false;
    believe(address, mote);
  }
  tell_later(address, mote);
}

/// Somebody waits for its readings: a mote that does not answer is told again after 5 s, then ever less often.
void Sampling::tell_later(std::uint16_t address, Mote& mote) {
  if (closed_ || mote.wish.mask == 0 || mote.again.pending()) return;
  const auto pause = std::min<Duration>(kPause * (1U << std::min(mote.failures++, 4U)), kLongestPause);
  mote.again = scheduler_.after(pause, [this, address] {
    Mote& late = motes_[address];
    if (late.asked || settled(late) || late.wish.mask == 0) return;
    if (!tell(address, late)) tell_later(address, late);
  });
}

void Sampling::joined(std::uint16_t address) {
  Mote& mote = motes_[address];
  mote.reports = mote.answers = mote.deaf = mote.woken = false;
  mote.others_until = {};
  mote.failures = 0;
  mote.told.reset();
  mote.reads.reset();
  mote.measured = 0;
  mote.first = mote.wish.mask != 0;
  believe(address, mote);
  if (mote.wish.mask != 0 && !mote.asked && !tell(address, mote)) tell_later(address, mote);
}

void Sampling::heard(std::uint16_t address, bool reported) {
  Mote& mote = motes_[address];
  if (reported) {
    mote.reports = true;
    mote.reported = scheduler_.now();
    if (mote.told) mote.measured = mote.told->mask;
    if (std::exchange(mote.first, false)) believe(address, mote);
  }
  if (!settled(mote) && may_tell(mote)) std::ignore = tell(address, mote);
}

void Sampling::overruled(std::uint16_t address, std::optional<std::uint16_t> mask) {
  const auto until = scheduler_.now() + kOthers;
  if (address == motes::kBroadcast) {
    all_others_until_ = until;
    for (auto& [one, mote] : motes_) overrule(one, mote, mask);
    return;
  }
  Mote& mote = motes_[address];
  mote.others_until = until;
  overrule(address, mote, mask);
}

void Sampling::overrule(std::uint16_t address, Mote& mote, std::optional<std::uint16_t> mask) {
  mote.overruled = mote.asked.has_value();
  mote.tried = scheduler_.now();
  mote.told.reset();
  mote.woken = false;
  if (!mask) return;
  mote.measured &= *mask;
  mote.reads = static_cast<std::uint16_t>(*mask & mote.reads.value_or(0));
  believe(address, mote);
}

void Sampling::obeys_others(std::uint16_t address, std::optional<std::uint16_t> mask) {
  for (auto& [one, mote] : motes_) {
    if (address != motes::kBroadcast && address != one) continue;
    mote.reads = mask;
    mote.first = mask && (*mask & ~mote.measured) != 0;
    believe(one, mote);
  }
}

std::vector<std::uint16_t> Sampling::woken() const {
  std::vector<std::uint16_t> all;
  for (const auto& [address, mote] : motes_) {
    if (mote.woken) all.push_back(address);
  }
  return all;
}

bool Sampling::close(Duration limit, ClosedCall closed) {
  const auto all = woken();
  closed_ = true;
  if (all.empty()) return false;
  for (auto& [address, mote] : motes_) {
    mote.wish = {};
    mote.again.cancel();
  }
  closing_.emplace();
  closing_->waiting.assign(all.begin(), all.end());
  closing_->closed = std::move(closed);
  closing_->limit = scheduler_.after(limit, [this] { end_closing(); });
  stop_some();
  return true;
}

void Sampling::stop_some() {
  auto& [waiting, under_way, untold, closed, limit] = *closing_;
  while (under_way.size() < kCalmedAtATime && !waiting.empty()) {
    const auto address = waiting.front();
    waiting.pop_front();
    Mote& mote = motes_[address];
    if (mote.asked || tell(address, mote)) {
      under_way.insert(address);
    } else {
      untold.push_back(address);
    }
  }
  if (under_way.empty()) limit = scheduler_.after(Duration::zero(), [this] { end_closing(); });
}

void Sampling::stop_ended(std::uint16_t address, Mote& mote, const Reads& asked, DeliveryResult how) {
  const bool read = asked.mask != 0;  // a command to read was under way: the one to stop follows it
  if (mote.asked || (read && tell(address, mote)) || closing_->under_way.erase(address) == 0) return;
  if (read || how != DeliveryResult::kAcknowledged) closing_->untold.push_back(address);
  stop_some();
}

void Sampling::end_closing() {
  auto closing = *std::exchange(closing_, std::nullopt);
  auto& untold = closing.untold;
  untold.insert(untold.end(), closing.under_way.begin(), closing.under_way.end());
  untold.insert(untold.end(), closing.waiting.begin(), closing.waiting.end());
  std::sort(untold.begin(), untold.end());
  closing.closed(untold);
}

}  // namespace rubicon::networks::wsn
