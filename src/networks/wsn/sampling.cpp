#include "networks/wsn/sampling.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "base/assert.h"
#include "motes/mote_records.h"

namespace rubicon::networks::wsn {

namespace {

const model::DeviceType& mote_type() {
  const auto all = TypeCatalogue::device_types();
  const auto found = std::find_if(all.begin(), all.end(), [](const auto& type) { return type.name == "mote"; });
  RUBICON_ASSERT(found != all.end());
  return *found;
}

}  // namespace

void MoteProperties::declare(std::uint16_t mote, model::Join& join) const {
  for (const auto& property : mote_type().properties) {
    model::Capability capability;
    capability.point = {Kind::kProperty, types_.find(property.property)->id, {}};
    capability.type_name = property.property;
    capability.access = property.access;
    const auto known = masks_.find(mote);
    if (property.property == "mask" && known != masks_.end()) capability.initial = std::int64_t{known->second};
    join.capabilities.push_back(std::move(capability));
  }
}

model::Updates MoteProperties::set_mask(std::uint16_t mote, std::uint16_t mask) {
  masks_[mote] = mask;
  const model::PointId point{Kind::kProperty, types_.find("mask")->id, {}};
  return model::Updates{{{point, std::int64_t{mask}, {}}}};
}

namespace {

constexpr std::int64_t kMaxTicks = 65535;
/// The radio carries some 90 messages a second; period 0 was never tried (wsn.md 2, 9.4).
constexpr std::int64_t kMinTicks = 51;
/// Between two commands to a mote that does not follow them.
constexpr Duration kPause = std::chrono::seconds(5);
constexpr Duration kMaxPause = std::chrono::minutes(1);
/// After the start nothing is throttled for this long, so that subscribers can find the island.
constexpr Duration kStartGrace = std::chrono::seconds(10);
/// No throttling after a command of another program.
constexpr Duration kOverrideTime = std::chrono::hours(1);
constexpr std::size_t kMaxThrottling = 8;
/// A mote whose last report is older than two and a half periods and this may have restarted without being heard.
constexpr Duration kReportTolerance = std::chrono::seconds(1);
constexpr Duration kTimeToLive = std::chrono::seconds(30);

Duration period_of(std::uint16_t ticks) {
  return Duration(std::chrono::nanoseconds(std::int64_t{ticks} * 1'000'000'000 / 1024));
}

}  // namespace

std::uint16_t ticks_of(std::chrono::milliseconds period) {
  constexpr std::int64_t kMax = kMaxTicks * 1000 / 1024;
  const std::int64_t bounded = std::clamp<std::int64_t>(period.count(), 0, kMax + 1);
  return static_cast<std::uint16_t>(std::clamp((bounded * 1024 + 500) / 1000, kMinTicks, kMaxTicks));
}

Sampling::Sampling(Scheduler& scheduler, MoteRequests& requests, SamplingOptions options, Callbacks callbacks)
    : scheduler_(scheduler),
      requests_(requests),
      options_(options),
      callbacks_(std::move(callbacks)),
      started_(scheduler.now()) {}

bool Sampling::up_to_date(const Mote& mote) const {
  if (mote.acknowledged) return *mote.acknowledged == mote.demanded;
  return mote.demanded.mask == 0 && !mote.reports;
}

/// A mote without demand is not throttled while its reports may serve subscribers who are about to find us again, or
/// another program. Only a few are throttled at a time, so that commands of others keep their room in the lane.
bool Sampling::may_command(const Mote& mote) const {
  const auto now = scheduler_.now();
  if (closed_ || mote.pending || now < mote.last_try + kPause) return false;
  if (mote.demanded.mask != 0) return true;
  return now >= std::max(mote.override_until, override_all_until_) && now >= started_ + kStartGrace &&
         throttling_ < kMaxThrottling;
}

Result<void> Sampling::demand(std::uint16_t address, SampleSetting setting) {
  if (closed_) return fail(ErrorCode::kUnreachable, "the island ends: its motes get the command to stop");
  Mote& mote = motes_[address];
  const bool repeated = mote.demanded == setting;
  mote.demanded = setting;
  mote.failures = 0;
  if (!repeated) mote.retry.cancel();  // its pause belongs to the former demand
  if (mote.pending) return {};         // ended() compares with the new demand
  // A repeated demand means that the reports are missed.
  if (up_to_date(mote) && (!repeated || setting.mask == 0)) return {};
  auto commanded = command(address, mote);
  if (!commanded) retry_later(address, mote);
  return commanded;
}

bool Sampling::has_acknowledged(std::uint16_t address, const SampleSetting& setting) const {
  const auto found = motes_.find(address);
  return found != motes_.end() && found->second.acknowledged == setting && found->second.demanded == setting;
}

Result<void> Sampling::command(std::uint16_t address, Mote& mote) {
  MoteRequest request;
  request.header.destination_island = request.header.source_island = options_.island;
  request.header.destination_mote = address;
  request.header.source_mote = motes::kBaseMote;
  request.header.reliable = 1;
  request.header.transport = motes::kTransportConnectionless;
  request.header.application = options_.read_updates ? motes::kApplicationControl : motes::kApplicationMockup;
  request.record = options_.read_updates
                       ? motes::encode_record(motes::ReadUpdates{mote.demanded.ticks, mote.demanded.mask})
                       : motes::encode_record(motes::PeriodicCommand{mote.demanded.mask, mote.demanded.ticks});
  request.lane = sink::Lane::kSampling;
  request.time_to_live = kTimeToLive;
  request.done = [this, address](DeliveryResult result) { ended(address, result); };
  mote.last_try = scheduler_.now();
  auto sent = requests_.send(std::move(request));
  if (!sent) return sent;
  mote.pending = mote.demanded;
  if (mote.demanded.mask == 0) ++throttling_;
  mote.active = mote.active || mote.demanded.mask != 0;
  // Until it answers, only what it reads before and after the command is known to be measured.
  discard_old_measurements(mote);
  mote.acknowledged.reset();
  mote.measured &= mote.demanded.mask;
  // An unknown setting stays unknown while the mote is throttled or ignores us; otherwise the next report may be the
  // first one after this command.
  const bool unknown = !mote.reads && (mote.ignores_us || mote.demanded.mask == 0);
  if (!unknown) mote.reads = static_cast<std::uint16_t>(mote.demanded.mask & mote.reads.value_or(0));
  notify_measures(address, mote);
  return {};
}

void Sampling::discard_old_measurements(Mote& mote) const {
  const auto max_age =
      mote.acknowledged ? period_of(mote.acknowledged->ticks) * 5 / 2 + kReportTolerance : kReportTolerance;
  if (mote.last_report + max_age < scheduler_.now()) mote.measured = 0;
}

void Sampling::notify_measures(std::uint16_t address, const Mote& mote) const {
  callbacks_.measures(address, mote.first_report ? mote.measured : mote.reads);
}

void Sampling::ended(std::uint16_t address, DeliveryResult result) {
  Mote& mote = motes_[address];
  const auto setting = std::exchange(mote.pending, std::nullopt);
  if (!setting) return;
  if (setting->mask == 0) --throttling_;
  if (result == DeliveryResult::kAcknowledged) {
    acknowledged(address, mote, *setting);
  } else {
    not_acknowledged(address, mote, result);
  }
  if (closing_) stop_ended(address, mote, *setting, result);
}

void Sampling::acknowledged(std::uint16_t address, Mote& mote, const SampleSetting& setting) {
  mote.failures = 0;
  mote.answers = true;
  mote.ignores_us = false;
  if (std::exchange(mote.overridden, false)) {  // which of the two commands the mote executed last is unknown
    mote.reads.reset();
    mote.measured = 0;
    mote.first_report = true;
    return notify_measures(address, mote);
  }
  mote.acknowledged = setting;
  mote.reads = setting.mask;
  mote.first_report = (setting.mask & ~mote.measured) != 0;
  mote.reports = true;
  if (setting.mask == 0) mote.active = false;
  notify_measures(address, mote);
  callbacks_.acknowledged(address, setting.mask);
  if (!up_to_date(mote)) std::ignore = command(address, mote);
}

/// A mote that never acknowledged a command does not hear us: it reports for another program.
void Sampling::not_acknowledged(std::uint16_t address, Mote& mote, DeliveryResult result) {
  if (result == DeliveryResult::kNoAnswer && !mote.answers) {
    mote.ignores_us = true;
    mote.reads.reset();
    mote.first_report = false;
    notify_measures(address, mote);
  }
  retry_later(address, mote);
}

/// While there is a demand, a mote that does not answer is commanded again after 5 s, then after growing pauses.
void Sampling::retry_later(std::uint16_t address, Mote& mote) {
  if (closed_ || mote.demanded.mask == 0 || mote.retry.pending()) return;
  const auto pause = std::min<Duration>(kPause * (1U << std::min(mote.failures++, 4U)), kMaxPause);
  mote.retry = scheduler_.after(pause, [this, address] {
    Mote& late = motes_[address];
    if (late.pending || up_to_date(late) || late.demanded.mask == 0) return;
    if (!command(address, late)) retry_later(address, late);
  });
}

void Sampling::joined(std::uint16_t address) {
  Mote& mote = motes_[address];
  mote.reports = mote.answers = mote.ignores_us = mote.active = false;
  mote.override_until = {};
  mote.failures = 0;
  mote.acknowledged.reset();
  mote.reads.reset();
  mote.measured = 0;
  mote.first_report = mote.demanded.mask != 0;
  notify_measures(address, mote);
  if (mote.demanded.mask != 0 && !mote.pending && !command(address, mote)) retry_later(address, mote);
}

void Sampling::heard(std::uint16_t address, bool reported) {
  Mote& mote = motes_[address];
  if (reported) {
    mote.reports = true;
    mote.last_report = scheduler_.now();
    if (mote.acknowledged) mote.measured = mote.acknowledged->mask;
    if (std::exchange(mote.first_report, false)) notify_measures(address, mote);
  }
  if (!up_to_date(mote) && may_command(mote)) std::ignore = command(address, mote);
}

void Sampling::override_begins(std::uint16_t address, std::optional<std::uint16_t> mask) {
  const auto until = scheduler_.now() + kOverrideTime;
  if (address == motes::kBroadcast) {
    override_all_until_ = until;
    for (auto& [one, mote] : motes_) override_one(one, mote, mask);
    return;
  }
  Mote& mote = motes_[address];
  mote.override_until = until;
  override_one(address, mote, mask);
}

void Sampling::override_one(std::uint16_t address, Mote& mote, std::optional<std::uint16_t> mask) {
  mote.overridden = mote.pending.has_value();
  mote.last_try = scheduler_.now();
  mote.acknowledged.reset();
  mote.active = false;
  if (!mask) return;
  mote.measured &= *mask;
  mote.reads = static_cast<std::uint16_t>(*mask & mote.reads.value_or(0));
  notify_measures(address, mote);
}

void Sampling::override_ends(std::uint16_t address, std::optional<std::uint16_t> mask) {
  for (auto& [one, mote] : motes_) {
    if (address != motes::kBroadcast && address != one) continue;
    mote.reads = mask;
    mote.first_report = mask && (*mask & ~mote.measured) != 0;
    notify_measures(one, mote);
  }
}

std::vector<std::uint16_t> Sampling::active() const {
  std::vector<std::uint16_t> all;
  for (const auto& [address, mote] : motes_) {
    if (mote.active) all.push_back(address);
  }
  return all;
}

bool Sampling::close(Duration limit, ClosedCallback closed) {
  const auto all = active();
  closed_ = true;
  if (all.empty()) return false;
  for (auto& [address, mote] : motes_) {
    mote.demanded = {};
    mote.retry.cancel();
  }
  closing_.emplace();
  closing_->waiting.assign(all.begin(), all.end());
  closing_->closed = std::move(closed);
  closing_->limit = scheduler_.after(limit, [this] { end_closing(); });
  stop_some();
  return true;
}

void Sampling::stop_some() {
  auto& [waiting, under_way, active, closed, limit] = *closing_;
  while (under_way.size() < kMaxThrottling && !waiting.empty()) {
    const auto address = waiting.front();
    waiting.pop_front();
    Mote& mote = motes_[address];
    if (mote.pending || command(address, mote)) {
      under_way.insert(address);
    } else {
      active.push_back(address);
    }
  }
  if (under_way.empty()) limit = scheduler_.after(Duration::zero(), [this] { end_closing(); });
}

void Sampling::stop_ended(std::uint16_t address, Mote& mote, const SampleSetting& setting, DeliveryResult result) {
  const bool read = setting.mask != 0;  // a command to read ended: the one to stop follows it
  if (mote.pending || (read && command(address, mote)) || closing_->under_way.erase(address) == 0) return;
  if (read || result != DeliveryResult::kAcknowledged) closing_->active.push_back(address);
  stop_some();
}

void Sampling::end_closing() {
  auto closing = *std::exchange(closing_, std::nullopt);
  auto& active = closing.active;
  active.insert(active.end(), closing.under_way.begin(), closing.under_way.end());
  active.insert(active.end(), closing.waiting.begin(), closing.waiting.end());
  std::sort(active.begin(), active.end());
  closing.closed(active);
}

}  // namespace rubicon::networks::wsn
