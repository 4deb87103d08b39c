#include "networks/knx/unassigned.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "model/json_text.h"

namespace rubicon::networks::knx {

void UnassignedAddresses::add(const wire::Telegram& telegram, WallTime now) {
  if (entries_.size() >= kMaxAddresses && !entries_.contains(telegram.destination)) {
    const auto older = [](const auto& one, const auto& other) { return one.second.time < other.second.time; };
    entries_.erase(std::min_element(entries_.begin(), entries_.end(), older));
    ++dropped_;
  }
  auto& entry = entries_[telegram.destination];
  ++entry.count;
  const auto& bytes = telegram.payload.bytes;
  if (telegram.service != wire::Service::kRead)
    entry.last = base::to_hex(ByteView(bytes).first(std::min(bytes.size(), kMaxValueBytes)));
  entry.source = telegram.source;
  entry.time = now;
}

std::string UnassignedAddresses::json(wire::Notation notation) const {
  auto all = nlohmann::ordered_json::object();
  for (const auto& [address, entry] : entries_) {
    all[to_string(address, notation)] = {{"count", entry.count},
                                         {"last", entry.last},
                                         {"source", to_string(entry.source)},
                                         {"time", base::to_seconds(entry.time)}};
  }
  return model::dump(all);
}

}  // namespace rubicon::networks::knx
