#include "networks/knx/unassigned.h"

#include <nlohmann/json.hpp>

namespace rubicon::networks::knx {

void Unassigned::heard(const Telegram& telegram, WallTime now) {
  if (entries_.size() >= kMost && !entries_.contains(telegram.destination)) return void(++dropped_);
  auto& entry = entries_[telegram.destination];
  ++entry.count;
  if (telegram.service != Service::kRead) entry.last = telegram.payload;
  entry.source = telegram.source;
  entry.time = now;
}

std::string Unassigned::json() const {
  auto all = nlohmann::ordered_json::object();
  for (const auto& [address, entry] : entries_) {
    all[to_string(address)] = {{"count", entry.count},
                               {"last", base::to_hex(entry.last.bytes)},
                               {"source", to_string(entry.source)},
                               {"time", base::to_seconds(entry.time)}};
  }
  return all.dump();
}

}  // namespace rubicon::networks::knx
