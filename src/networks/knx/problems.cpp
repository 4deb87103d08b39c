#include "networks/knx/problems.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "model/json_text.h"

namespace rubicon::networks::knx {

void Problems::add(const Problem& problem, WallTime now) {
  const auto key = std::make_pair(problem.address, problem.what);
  if (entries_.size() >= kMaxCount && !entries_.contains(key)) {
    const auto older = [](const auto& one, const auto& other) { return one.second.time < other.second.time; };
    entries_.erase(std::min_element(entries_.begin(), entries_.end(), older));
  }
  auto& entry = entries_[key];
  ++entry.count;
  entry.reason = problem.reason;
  entry.time = now;
}

void Problems::end(std::string_view what, wire::GroupAddress address) {
  entries_.erase({address, what});
}

std::string Problems::json(wire::Notation notation) const {
  auto all = nlohmann::ordered_json::array();
  for (const auto& [key, entry] : entries_) {
    all.push_back({{"address", to_string(key.first, notation)},
                   {"what", std::string(key.second)},
                   {"count", entry.count},
                   {"reason", entry.reason},
                   {"time", base::to_seconds(entry.time)}});
  }
  return model::dump(all);
}

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
