#include "networks/knx/exposures.h"

#include <algorithm>
#include <utility>

#include "model/point_keys.h"
#include "model/point_tuples.h"

namespace rubicon::networks::knx {

namespace {

/// What could not be written is tried again after this time.
constexpr Duration kRetry = std::chrono::seconds(10);

/// Of the `.status` beside a value: whether there is a value to show at all.
bool is_usable(std::string_view status) {
  const auto quality = model::point_status_from_json(status).quality;
  return quality.empty() || quality == "good" || quality == "assumed";
}

}  // namespace

Exposures::Exposures(network::NetworkHost& host, const TypeCatalogue& types, Out out, Unfit unfit)
    : host_(host), types_(types), out_(std::move(out)), unfit_(std::move(unfit)) {}

void Exposures::take(std::vector<Exposure> wanted) {
  auto before = std::exchange(shown_, {});
  for (auto& what : wanted) {
    const auto same =
        std::find_if(before.begin(), before.end(), [&](const auto& one) { return one && one->what == what; });
    if (same != before.end()) {
      shown_.push_back(std::move(*same));
    } else {
      follow(shown_.emplace_back(std::make_shared<Shown>()), std::move(what));
    }
  }
}

/// A value that is bad, stale or gone is none: a controller on the bus must not go by it.
void Exposures::follow(const std::shared_ptr<Shown>& shown, Exposure what) {
  shown->what = std::move(what);
  auto& one = *shown;
  if (model::last_part(one.what.tuple) == "value") {
    const model::PointKey point{std::string(model::parent_key(one.what.tuple))};
    if (auto followed = host_.watch_tuple(point.status(), [this, &one](std::string_view text) {
          one.usable = is_usable(text);
          changed(one);
        }))
      one.status = std::move(*followed);
  }
  auto followed = host_.watch_tuple(one.what.tuple, [this, &one](std::string_view text) {
    one.text = text;
    changed(one);
  });
  if (!followed) return unfit_(one.what, followed.error());
  one.value = std::move(*followed);
}

/// Values are text in the catalogue's unit and words.
Result<wire::Payload> Exposures::payload_of(const Exposure& what, std::string_view text) const {
  const auto* dpt = dpt::find_dpt(what.dpt);
  const auto* type = types_.find(dpt->sensor);
  const auto value = type ? TypeCatalogue::parse(*type, text) : Result<Value>(fail(ErrorCode::kInvalid, "no type"));
  if (!value) return dpt::encode_text(*dpt, text);
  const auto converted = dpt::from_catalogue(*dpt, Kind::kSensor, *value);
  return converted ? encode(*dpt, *converted) : fail(converted.error());
}

void Exposures::changed(Shown& shown) {
  if (shown.text.empty() || !shown.usable) return nothing(shown);
  auto payload = payload_of(shown.what, shown.text);
  if (!payload) {
    unfit_(shown.what, payload.error());
    return nothing(shown);
  }
  const bool first = !shown.payload;
  if (shown.payload == *payload) return;
  shown.payload = std::move(*payload);
  if (up_ && shown.what.on_change) {
    write_change(shown);
  } else if (up_ && first && shown.what.every) {
    write(shown);
  }
}

void Exposures::nothing(Shown& shown) {
  shown.payload.reset();
  shown.again.cancel();
  shown.retry.cancel();
  shown.waits = false;
}

/// A sensor may speak much faster than a line of the bus has room for.
void Exposures::write_change(Shown& shown) {
  shown.waits = shown.pause.pending();
  if (!shown.waits) write(shown);
}

/// Whatever the occasion, it is the newest value that goes out: none waits after it.
void Exposures::write(Shown& shown) {
  shown.waits = false;
  rest(shown);
  wire::Telegram telegram;
  telegram.destination = shown.what.address;
  telegram.payload = *shown.payload;
  const auto self = std::find_if(shown_.begin(), shown_.end(), [&](const auto& one) { return one.get() == &shown; });
  out_(std::move(telegram), [this, weak = std::weak_ptr<Shown>(*self)](bool sent) {
    if (const auto one = weak.lock(); one && !sent) retry(*one);
  });
  if (!shown.what.every) return;
  shown.again = host_.scheduler().after(*shown.what.every, [this, &shown] {
    if (up_ && shown.payload) write(shown);
  });
}

void Exposures::rest(Shown& shown) {
  if (!shown.what.on_change || shown.what.pause == Duration::zero()) return;
  shown.pause = host_.scheduler().after(shown.what.pause, [this, &shown] {
    if (shown.waits && up_ && shown.payload) write(shown);
  });
}

void Exposures::retry(Shown& shown) {
  shown.retry = host_.scheduler().after(kRetry, [this, &shown] {
    if (up_ && shown.payload) write(shown);
  });
}

void Exposures::line_up() {
  if (std::exchange(up_, true)) return;
  for (const auto& shown : shown_) {
    if (shown->payload && (shown->what.on_change || shown->what.every)) write(*shown);
  }
}

bool Exposures::asked(const wire::Telegram& question) {
  const auto found = std::find_if(shown_.begin(), shown_.end(),
                                  [&](const auto& one) { return one->what.address == question.destination; });
  if (found == shown_.end()) return false;
  if (!(*found)->payload) return true;
  wire::Telegram answer;
  answer.service = wire::Service::kResponse;
  answer.destination = question.destination;
  answer.payload = *(*found)->payload;
  answer.priority = question.priority;
  out_(std::move(answer), [](bool) {});
  return true;
}

bool Exposures::shows(wire::GroupAddress address) const {
  return std::any_of(shown_.begin(), shown_.end(), [&](const auto& one) { return one->what.address == address; });
}

}  // namespace rubicon::networks::knx
