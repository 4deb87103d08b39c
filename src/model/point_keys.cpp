#include "model/point_keys.h"

#include <fmt/format.h>

#include "rubicon/key.hpp"

namespace rubicon::model {

namespace {

/// Of `<prefix>.<network>.<device>.<kind>.<id>.<last>`.
constexpr std::size_t kPointTupleParts = 6;

bool is_tuple_of_point(std::string_view last) {
  return last == "value" || last == "status" || last == "command" || last == "description";
}

}  // namespace

PointKey DeviceKey::point(std::string_view kind, std::string_view id) const {
  return {fmt::format("{}.{}.{}", text, kind, id)};
}

std::string NetworkKey::property(std::string_view name) const {
  return control(name).value();
}

PointKey NetworkKey::control(std::string_view name) const {
  return {fmt::format("{}.property.{}", text, name)};
}

DeviceKey NetworkKey::device(std::string_view id) const {
  return {fmt::format("{}.{}", text, id)};
}

std::string IslandKey::inbox(std::string_view device) const {
  return fmt::format("{}.inbox.{}", text, device);
}

std::string IslandKey::property(std::string_view name) const {
  return fmt::format("{}.property.{}.value", text, name);
}

PointKey IslandKey::recorder(std::string_view name) const {
  return {fmt::format("{}.recorder.{}", text, name)};
}

PointKey IslandKey::bridge(std::string_view name) const {
  return {fmt::format("{}.bridge.{}", text, name)};
}

NetworkKey IslandKey::network(std::string_view id) const {
  return {fmt::format("{}.{}", text, id)};
}

PointKey any_point() {
  return IslandKey{"*"}.network("*").device("*").point("*", "*");
}

bool is_part_of_island(std::string_view part) {
  return part == "bridge" || part == "history" || part == "inbox" || part == "property" || part == "recorder" ||
         part == "settings";
}

bool is_of_island(std::string_view key) {
  const auto parts = key_parts(key);
  return parts.size() > 1 && is_part_of_island(parts[1]);
}

bool is_line_command(std::string_view key) {
  const auto parts = key_parts(key);
  return parts.size() == 5 && parts[2] == "property" && parts[3] == "line" && parts[4] == "command";
}

std::string_view parent_key(std::string_view key) {
  const auto dot = key.rfind('.');
  return key.substr(0, dot == key.npos ? 0 : dot);
}

std::string_view last_part(std::string_view key) {
  return key.substr(key.rfind('.') + 1);
}

std::optional<NetworkKey> network_of(std::string_view key) {
  const auto parts = key_parts(key);
  if (parts.size() < 2) return std::nullopt;
  return IslandKey{std::string(parts[0])}.network(parts[1]);
}

std::optional<PointKey> point_of(std::string_view key) {
  const auto parts = key_parts(key);
  if (parts.size() != kPointTupleParts || !parse_kind(parts[3]) || !is_tuple_of_point(parts[5])) return std::nullopt;
  return PointKey{std::string(parent_key(key))};
}

}  // namespace rubicon::model
