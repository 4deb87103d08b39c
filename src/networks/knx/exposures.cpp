#include "networks/knx/exposures.h"

#include <algorithm>
#include <utility>

#include "model/point_keys.h"
#include "model/point_tuples.h"

namespace rubicon::networks::knx {

namespace {

/// Pause before a telegram that did not reach the bus is sent again.
constexpr Duration kRetryPause = std::chrono::seconds(10);

/// Whether a value with this `.status` beside it may be sent to the bus.
bool is_usable(std::string_view status) {
  const auto quality = model::point_status_from_json(status).quality;
  return quality.empty() || quality == "good" || quality == "assumed";
}

}  // namespace

Exposures::Exposures(network::NetworkHost& host, const TypeCatalogue& types, Send send, OnError on_error)
    : host_(host), types_(types), send_(std::move(send)), on_error_(std::move(on_error)) {}

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
}

/// The `.status` is watched too: a controller on the bus must not act on a value that is bad, stale or gone.
void Exposures::watch(const std::shared_ptr<Entry>& added, Exposure exposure) {
  auto& entry = *added;
  entry.exposure = std::move(exposure);
  if (model::last_part(entry.exposure.tuple) == "value") {
    const model::PointKey point{std::string(model::parent_key(entry.exposure.tuple))};
    if (auto watched = host_.watch_tuple(point.status(), [this, &entry](std::string_view text) {
          entry.usable = is_usable(text);
          update(entry);
        }))
      entry.status = std::move(*watched);
  }
  auto watched = host_.watch_tuple(entry.exposure.tuple, [this, &entry](std::string_view text) {
    entry.text = text;
    update(entry);
  });
  if (!watched) return on_error_(entry.exposure, watched.error());
  entry.value = std::move(*watched);
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
  if (entry.text.empty() || !entry.usable) return clear(entry);
  auto payload = payload_of(entry.exposure, entry.text);
  if (!payload) {
    on_error_(entry.exposure, payload.error());
    return clear(entry);
  }
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
  if (std::exchange(entry.on_the_way, true)) return;
  start_pause(entry);
  wire::Telegram telegram;
  telegram.destination = entry.exposure.address;
  telegram.payload = *entry.payload;
  const auto self =
      std::find_if(entries_.begin(), entries_.end(), [&](const auto& one) { return one.get() == &entry; });
  send_(std::move(telegram), [this, weak = std::weak_ptr<Entry>(*self)](bool sent) {
    if (const auto one = weak.lock()) written(*one, sent);
  });
  if (!entry.exposure.every) return;
  entry.cyclic = host_.scheduler().after(*entry.exposure.every, [this, &entry] {
    if (up_ && entry.payload) write(entry);
  });
}

void Exposures::written(Entry& entry, bool sent) {
  entry.on_the_way = false;
  if (!sent) return retry(entry);
  if (entry.change_waits && !entry.pause.pending() && up_ && entry.payload) write(entry);
}

void Exposures::start_pause(Entry& entry) {
  if (!entry.exposure.on_change || entry.exposure.pause == Duration::zero()) return;
  entry.pause = host_.scheduler().after(entry.exposure.pause, [this, &entry] {
    if (entry.change_waits && up_ && entry.payload) write(entry);
  });
}

void Exposures::retry(Entry& entry) {
  entry.retry = host_.scheduler().after(kRetryPause, [this, &entry] {
    if (up_ && entry.payload) write(entry);
  });
}

void Exposures::line_up() {
  if (std::exchange(up_, true)) return;
  for (const auto& entry : entries_) {
    if (entry->payload && (entry->exposure.on_change || entry->exposure.every)) write(*entry);
  }
}

bool Exposures::answer(const wire::Telegram& read) {
  const auto found = std::find_if(entries_.begin(), entries_.end(),
                                  [&](const auto& entry) { return entry->exposure.address == read.destination; });
  if (found == entries_.end()) return false;
  if (!(*found)->payload) return true;
  wire::Telegram response;
  response.service = wire::Service::kResponse;
  response.destination = read.destination;
  response.payload = *(*found)->payload;
  response.priority = read.priority;
  send_(std::move(response), [](bool) {});
  return true;
}

bool Exposures::contains(wire::GroupAddress address) const {
  return std::any_of(entries_.begin(), entries_.end(),
                     [&](const auto& entry) { return entry->exposure.address == address; });
}

}  // namespace rubicon::networks::knx
