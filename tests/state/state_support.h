#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "model/message.h"
#include "state/state_store.h"
#include "support/folder.h"

namespace rubicon::state {

inline constexpr IslandId kIsland{6541};

using support::Folder;

inline WallTime at(std::int64_t seconds) {
  return WallTime(std::chrono::seconds(1'790'000'000 + seconds));
}

inline model::PointId sensor(std::uint16_t type, std::string instance = "1") {
  return {Kind::kSensor, TypeId(type), std::move(instance)};
}

inline StoredValue value_at(model::PointId point, model::Value value, std::int64_t seconds) {
  return {std::move(point), std::move(value), at(seconds), at(seconds), {}, false};
}

/// A device with two sensors and no values.
inline KnownDevice device_of(const std::string& network, const std::string& address) {
  KnownDevice device;
  device.network = network;
  device.address = address;
  device.id = "id_" + address;
  device.join = {"mote", "Mote " + address, "EM1000", {}, true, "wanted_" + address};
  for (const auto type : {std::uint16_t{1}, std::uint16_t{2}}) {
    model::Capability capability;
    capability.point = sensor(type);
    capability.unit = "Cel";
    capability.minimum = -40.5;
    capability.deadline = std::chrono::seconds(60);
    device.join.capabilities.push_back(capability);
    device.point_ids.emplace_back(capability.point, fmt::format("type{}-1", type));
  }
  device.first_seen = device.last_heard = at(0);
  return device;
}

inline std::string text_of(const model::PointId& point) {
  return fmt::format("{}:{}:{}", to_string(point.kind), static_cast<unsigned>(point.type), point.instance);
}

/// All there is to a device, for comparing.
inline std::string text_of(const KnownDevice& device) {
  Message join;
  join.body = device.join;
  auto text = fmt::format("{}/{} id={} {} first={} last={} join={}", device.network, device.address, device.id,
                          to_string(device.decision), device.first_seen.time_since_epoch().count(),
                          device.last_heard.time_since_epoch().count(), base::to_hex(model::to_cbor(join)));
  text += fmt::format(" given={}/{}", device.given_name, device.area);
  for (const auto& [point, id] : device.point_ids) text += fmt::format(" {}->{}", text_of(point), id);
  for (const auto& value : device.values) {
    text += fmt::format(" {}={}|{}|{}|{}|{}|{}", text_of(value.point), value.value.index(), to_text(value.value),
                        value.heard.time_since_epoch().count(), value.changed.time_since_epoch().count(),
                        value.user_time.time_since_epoch().count(), value.set_by_user);
  }
  return text;
}

/// Every device of a store, one a line, after what wsn-1 remembers as `sequence`; the error's text instead if it cannot
/// be read.
inline std::string snapshot(const StateStore& store) {
  const auto sequence = store.remembered("wsn-1", "sequence");
  if (!sequence) return sequence.error().text;
  std::string text = *sequence ? base::to_hex(**sequence) + "\n" : "";
  const auto read = store.each("", [&](StateStore::Row, KnownDevice&& device) { text += text_of(device) + "\n"; });
  return read ? text : read.error().text;
}

inline std::unique_ptr<StateStore> opened(const std::string& path, StateOptions options = {}) {
  auto store = StateStore::open(path, kIsland, options);
  if (!store) ADD_FAILURE() << store.error().text;
  return store ? std::move(*store) : nullptr;
}

inline std::string read_all(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void write_all(const std::string& path, const std::string& content) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << content;
}

}  // namespace rubicon::state
