#include "networks/knx/exposures.h"

#include <algorithm>
#include <utility>

namespace rubicon::networks::knx {

Exposures::Exposures(network::NetworkHost& host, const TypeCatalogue& types, Out out, Unfit unfit)
    : host_(host), types_(types), out_(std::move(out)), unfit_(std::move(unfit)) {}

void Exposures::take(std::vector<Exposure> wanted) {
  auto before = std::exchange(shown_, {});
  for (auto& what : wanted) {
    const auto same =
        std::find_if(before.begin(), before.end(), [&](const auto& one) { return one && one->what == what; });
    if (same != before.end()) {
      shown_.push_back(std::move(*same));
      continue;
    }
    auto& shown = *shown_.emplace_back(std::make_unique<Shown>());
    shown.what = std::move(what);
    auto followed = host_.follow(shown.what.tuple, [this, &shown](std::string_view text) { changed(shown, text); });
    if (followed) {
      shown.followed = std::move(*followed);
    } else {
      unfit_(shown.what, followed.error());
    }
  }
}

/// Values are text in the catalogue's unit and words; an empty one says that nothing is known.
Result<Payload> Exposures::payload_of(const Exposure& what, std::string_view text) const {
  const auto* dpt = find_dpt(what.dpt);
  const auto* type = types_.find(dpt->sensor);
  const auto value = type ? TypeCatalogue::parse(*type, text) : Result<Value>(fail(ErrorCode::kInvalid, "no type"));
  if (!value) return encode_text(*dpt, text);
  const auto converted = from_catalogue(*dpt, Kind::kSensor, *value);
  return converted ? encode(*dpt, *converted) : fail(converted.error());
}

void Exposures::changed(Shown& shown, std::string_view text) {
  if (text.empty()) return;
  auto payload = payload_of(shown.what, text);
  if (!payload) return unfit_(shown.what, payload.error());
  const bool first = !shown.payload;
  if (shown.payload == *payload) return;
  shown.payload = std::move(*payload);
  if (up_ && shown.what.on_change) {
    write_change(shown);
  } else if (up_ && first && shown.what.every) {
    write(shown);
  }
}

/// A sensor may speak much faster than a line of the bus has room for.
void Exposures::write_change(Shown& shown) {
  shown.waits = shown.pause.pending();
  if (shown.waits) return;
  write(shown);
  if (shown.what.pause == Duration::zero()) return;
  shown.pause = host_.scheduler().after(shown.what.pause, [this, &shown] {
    if (shown.waits && up_) write_change(shown);
  });
}

void Exposures::write(Shown& shown) {
  Telegram telegram;
  telegram.destination = shown.what.address;
  telegram.payload = *shown.payload;
  out_(std::move(telegram));
  if (!shown.what.every) return;
  shown.again = host_.scheduler().after(*shown.what.every, [this, &shown] {
    if (up_) write(shown);
  });
}

void Exposures::line_up() {
  if (std::exchange(up_, true)) return;
  for (const auto& shown : shown_) {
    if (shown->payload && (shown->what.on_change || shown->what.every)) write(*shown);
  }
}

void Exposures::asked(const Telegram& question) {
  for (const auto& shown : shown_) {
    if (shown->what.address != question.destination || !shown->payload) continue;
    Telegram answer;
    answer.service = Service::kResponse;
    answer.destination = question.destination;
    answer.payload = *shown->payload;
    answer.priority = question.priority;
    return out_(std::move(answer));
  }
}

}  // namespace rubicon::networks::knx
