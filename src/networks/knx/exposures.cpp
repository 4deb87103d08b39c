#include "networks/knx/exposures.h"

#include <fmt/format.h>
#include <sys/timex.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <utility>

#include "base/clocks.h"
#include "model/point_keys.h"
#include "model/point_tuples.h"

namespace rubicon::networks::knx {

namespace {

constexpr WallTime kNeverSet{std::chrono::seconds(1'577'836'800)};  // 2020
constexpr dpt::DptId kTime{10, 1}, kDate{11, 1}, kDateTime{19, 1};

std::tm calendar(ClockZone zone, WallTime now) {
  const auto seconds =
      static_cast<std::time_t>(std::chrono::floor<std::chrono::seconds>(now.time_since_epoch()).count());
  std::tm parts{};
  zone == ClockZone::kLocal ? localtime_r(&seconds, &parts) : gmtime_r(&seconds, &parts);
  return parts;
}

}  // namespace

bool is_clock_type(dpt::DptId id) {
  return id == kTime || id == kDate || id == kDateTime;
}

Result<wire::Payload> clock_payload(dpt::DptId id, ClockZone zone, WallTime now, bool synchronised) {
  if (now < kNeverSet)
    return fail(ErrorCode::kRefused, fmt::format("the clock of this host shows {}: it was never set",
                                                 base::utc_text(now, "%Y-%m-%d %H:%M")));
  constexpr std::array kDays{"Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"};
  const auto parts = calendar(zone, now);
  const auto date = fmt::format("{:04}-{:02}-{:02}", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday);
  const auto time = fmt::format("{:02}:{:02}:{:02}", parts.tm_hour, parts.tm_min, std::min(parts.tm_sec, 59));
  const auto& type = *dpt::find_dpt(id);
  if (id == kDate) return dpt::encode_text(type, date);
  if (id == kTime)
    return dpt::encode_text(type, fmt::format("{} {}", kDays.at(static_cast<std::size_t>(parts.tm_wday)), time));
  return dpt::encode_text(type, fmt::format(R"({{"dateTime":"{}T{}","summerTime":{},"externalSync":{}}})", date, time,
                                            parts.tm_isdst > 0, synchronised));
}

std::int64_t clock_era(ClockZone zone, WallTime now) {
  const auto parts = calendar(zone, now);
  return (std::int64_t{parts.tm_year} * 366 + parts.tm_yday) * 1'000'000 + parts.tm_gmtoff;
}

/// A service may be forbidden to ask the kernel; systemd-timesyncd leaves a file.
bool is_clock_synchronised() {
  timex state{};
  if (::adjtimex(&state) >= 0) return (state.status & STA_UNSYNC) == 0;
  return ::access("/run/systemd/timesync/synchronized", F_OK) == 0;
}

namespace {

/// Pause before a telegram that did not reach the bus is sent again.
constexpr Duration kRetryPause = std::chrono::seconds(10);
constexpr Duration kClockLook = std::chrono::minutes(1);
/// A clock that differs by more was set.
constexpr Duration kClockSet = std::chrono::seconds(2);

/// Whether a value with this `.status` beside it may be sent to the bus.
bool is_usable(std::string_view status) {
  const auto quality = model::point_status_from_json(status).quality;
  return quality.empty() || quality == "good" || quality == "assumed";
}

/// Why a value with this `.status` is not usable.
std::string why_unusable(std::string_view status) {
  const auto read = model::point_status_from_json(status);
  return fmt::format("its value is {}{}{}", read.quality, read.reason.empty() ? "" : ": ", read.reason);
}

}  // namespace

Exposures::Exposures(network::NetworkHost& host, const TypeCatalogue& types, Send send, Report report)
    : host_(host), types_(types), send_(std::move(send)), report_(std::move(report)) {}

void Exposures::set(std::vector<Exposure> exposures) {
  auto before = std::exchange(entries_, {});
  for (auto& exposure : exposures) {
    const auto same =
        std::find_if(before.begin(), before.end(), [&](const auto& old) { return old && old->exposure == exposure; });
    if (same != before.end()) {
      entries_.push_back(std::move(*same));
    } else {
      watch(entries_.emplace_back(std::make_shared<Entry>()), std::move(exposure));
    }
  }
  for (const auto& gone : before) {
    if (gone && gone->silent) report_.over(gone->exposure.address);
  }
  const bool clocks =
      std::any_of(entries_.begin(), entries_.end(), [](const auto& one) { return one->exposure.clock.has_value(); });
  clock_look_ = clocks ? host_.scheduler().after(kClockLook, [this] { look_at_clock(); }) : Timer();
  clock_offset_ = host_.scheduler().wall_now().time_since_epoch() - host_.scheduler().now().time_since_epoch();
}

void Exposures::look_at_clock() {
  clock_look_ = host_.scheduler().after(kClockLook, [this] { look_at_clock(); });
  const auto now = host_.scheduler().wall_now();
  const Duration offset = now.time_since_epoch() - host_.scheduler().now().time_since_epoch();
  const bool was_set = std::chrono::abs(offset - std::exchange(clock_offset_, offset)) > kClockSet;
  for (const auto& entry : entries_) {
    const auto& clock = entry->exposure.clock;
    if (up_ && clock && entry->exposure.on_change && (was_set || clock_era(*clock, now) != entry->era)) write(*entry);
  }
}

std::optional<wire::Payload> Exposures::present(const Entry& entry) {
  const auto& clock = entry.exposure.clock;
  if (!clock) return entry.payload;
  auto payload = clock_payload(entry.exposure.dpt, *clock, host_.scheduler().wall_now(), is_clock_synchronised());
  if (payload) return std::move(*payload);
  refuse(entry, payload.error().text);
  return std::nullopt;
}

/// The `.status` is watched too: a controller on the bus must not act on a value that is bad, stale or gone.
void Exposures::watch(const std::shared_ptr<Entry>& added, Exposure exposure) {
  auto& entry = *added;
  entry.exposure = std::move(exposure);
  if (entry.exposure.clock) {
    if (up_ && (entry.exposure.on_change || entry.exposure.every)) write(entry);
    return;
  }
  if (model::last_part(entry.exposure.tuple) == "value") {
    const model::PointKey point{std::string(model::parent_key(entry.exposure.tuple))};
    if (auto watched = host_.watch_tuple(point.status(), [this, &entry](std::string_view text) {
          entry.status = text;
          entry.usable = is_usable(text);
          update(entry);
        }))
      entry.status_watch = std::move(*watched);
  }
  auto watched = host_.watch_tuple(entry.exposure.tuple, [this, &entry](std::string_view text) {
    entry.text = text;
    entry.heard = entry.heard || !text.empty();
    update(entry);
  });
  if (!watched) return report_.problem({kNoSource, entry.exposure.address, watched.error().text});
  entry.value_watch = std::move(*watched);
  await_source(entry);
}

/// An event has no value most of the time: its status is good all the same.
void Exposures::await_source(Entry& entry) {
  if (entry.silent || entry.source.pending()) return;
  entry.source = host_.scheduler().after(kSourceWait, [this, &entry] {
    if (entry.usable && !(entry.text.empty() && entry.status.empty())) return;
    entry.silent = true;
    const auto why = !entry.usable ? why_unusable(entry.status)
                     : entry.heard ? std::string("the tuple is gone")
                                   : std::string("no component has published this tuple");
    report_.problem({kNoSource, entry.exposure.address, fmt::format("{}: {}", entry.exposure.tuple, why)});
  });
}

void Exposures::has_source(Entry& entry) {
  entry.source.cancel();
  if (std::exchange(entry.silent, false)) report_.over(entry.exposure.address);
}

std::size_t Exposures::without_value() const {
  return static_cast<std::size_t>(
      std::count_if(entries_.begin(), entries_.end(), [](const auto& entry) { return entry->silent; }));
}

void Exposures::refuse(const Entry& entry, std::string_view why) {
  ++refused_;
  report_.problem({kRefusedExposure, entry.exposure.address, fmt::format("{}: {}", entry.exposure.tuple, why)});
}

/// `text` is in the unit and words of the type catalogue.
Result<wire::Payload> Exposures::payload_of(const Exposure& exposure, std::string_view text) const {
  const auto* dpt = dpt::find_dpt(exposure.dpt);
  const auto* type = types_.find(dpt->sensor);
  const auto value =
      type ? TypeCatalogue::parse_reading(*type, text) : Result<Value>(fail(ErrorCode::kInvalid, "no type"));
  if (!value) return dpt::encode_text(*dpt, text);
  const auto converted = dpt::from_catalogue(*dpt, Kind::kSensor, *value);
  return converted ? encode(*dpt, *converted) : fail(converted.error());
}

void Exposures::update(Entry& entry) {
  // An event that is over while its telegram waits is written all the same (`stop` of a blind).
  entry.ends = entry.text.empty() && entry.usable && entry.change_waits;
  if (entry.ends) return;
  if (entry.text.empty() || !entry.usable) return clear(entry);
  auto payload = payload_of(entry.exposure, entry.text);
  if (!payload) {
    refuse(entry, payload.error().text);
    return clear(entry);
  }
  has_source(entry);
  const bool first = !entry.payload;
  if (entry.payload == *payload) return;
  entry.payload = std::move(*payload);
  if (up_ && entry.exposure.on_change) {
    write_change(entry);
  } else if (up_ && first && entry.exposure.every) {
    write(entry);
  }
}

void Exposures::clear(Entry& entry) {
  entry.payload.reset();
  entry.cyclic.cancel();
  entry.retry.cancel();
  entry.change_waits = false;
  if (entry.text.empty() || !entry.usable) {
    await_source(entry);
  } else {
    has_source(entry);
  }
}

/// At most one change per pause: a sensor may report faster than the bus can carry.
void Exposures::write_change(Entry& entry) {
  entry.change_waits = entry.pause.pending();
  if (!entry.change_waits) write(entry);
}

/// Sends the newest value, so no change waits after it. While a telegram with an older one waits for its turn on the
/// line, this waits for its end: the bus gets no values that are out of date.
void Exposures::write(Entry& entry) {
  entry.change_waits = entry.on_the_way;
  if (entry.on_the_way) return;
  auto payload = present(entry);
  if (entry.exposure.clock) entry.era = clock_era(*entry.exposure.clock, host_.scheduler().wall_now());
  repeat(entry);
  if (!payload) return;
  entry.on_the_way = true;
  start_pause(entry);
  wire::Telegram telegram;
  telegram.destination = entry.exposure.address;
  telegram.payload = std::move(*payload);
  if (std::exchange(entry.ends, false)) clear(entry);
  const auto self =
      std::find_if(entries_.begin(), entries_.end(), [&](const auto& one) { return one.get() == &entry; });
  send_(std::move(telegram), [this, weak = std::weak_ptr<Entry>(*self)](bool sent, std::string_view refused) {
    if (const auto one = weak.lock()) written(*one, sent, refused);
  });
}

void Exposures::repeat(Entry& entry) {
  if (!entry.exposure.every) return;
  entry.cyclic = host_.scheduler().after(*entry.exposure.every, [this, &entry] {
    if (up_ && has_value(entry)) write(entry);
  });
}

void Exposures::written(Entry& entry, bool sent, std::string_view refused) {
  entry.on_the_way = false;
  if (!refused.empty()) refuse(entry, refused);
  if (!sent) return retry(entry);
  if (entry.change_waits && !entry.pause.pending() && up_ && has_value(entry)) write(entry);
}

void Exposures::start_pause(Entry& entry) {
  if (!entry.exposure.on_change || entry.exposure.pause == Duration::zero()) return;
  entry.pause = host_.scheduler().after(entry.exposure.pause, [this, &entry] {
    if (entry.change_waits && up_ && has_value(entry)) write(entry);
  });
}

void Exposures::retry(Entry& entry) {
  entry.retry = host_.scheduler().after(kRetryPause, [this, &entry] {
    if (up_ && has_value(entry)) write(entry);
  });
}

void Exposures::line_up() {
  if (std::exchange(up_, true)) return;
  for (const auto& entry : entries_) {
    if (std::exchange(entry->ends, false)) clear(*entry);
    if (has_value(*entry) && (entry->exposure.on_change || entry->exposure.every)) write(*entry);
  }
}

bool Exposures::answer(const wire::Telegram& read) {
  const auto found = std::find_if(entries_.begin(), entries_.end(),
                                  [&](const auto& entry) { return entry->exposure.address == read.destination; });
  if (found == entries_.end()) return false;
  auto payload = present(**found);
  if (!payload) return true;
  wire::Telegram response;
  response.service = wire::Service::kResponse;
  response.destination = read.destination;
  response.payload = std::move(*payload);
  response.priority = read.priority;
  send_(std::move(response), [this, weak = std::weak_ptr<Entry>(*found)](bool, std::string_view refused) {
    if (const auto one = weak.lock(); one && !refused.empty()) refuse(*one, refused);
  });
  return true;
}

bool Exposures::contains(wire::GroupAddress address) const {
  return std::any_of(entries_.begin(), entries_.end(),
                     [&](const auto& entry) { return entry->exposure.address == address; });
}

}  // namespace rubicon::networks::knx
