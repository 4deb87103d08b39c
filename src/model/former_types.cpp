#include "model/former_types.h"

#include <algorithm>

#include "rubicon/key.hpp"

namespace rubicon::model {

namespace {

constexpr TypeId kLight{0x0001};
constexpr TypeId kMotion{0x000a};
constexpr FormerType kFormer[] = {{TypeId(0x0400), "illuminance", kLight, "light"},
                                  {TypeId(0x0202), "pir", kMotion, "motion"}};

}  // namespace

std::span<const FormerType> former_types() {
  return kFormer;
}

TypeId current_type(TypeId id) {
  const auto* found = std::ranges::find(kFormer, id, &FormerType::id);
  return found == std::end(kFormer) ? id : found->now;
}

std::string_view current_type(std::string_view name) {
  const auto* found = std::ranges::find(kFormer, name, &FormerType::name);
  return found == std::end(kFormer) ? name : found->called;
}

std::string current_id(std::string_view id) {
  const auto dash = std::min(id.find('-'), id.size());
  std::string now(current_type(id.substr(0, dash)));
  return now += id.substr(dash);
}

PointId current_point(PointId point) {
  point.type = current_type(point.type);
  if (point.kind == Kind::kProperty) point.instance = current_id(point.instance);
  return point;
}

std::string current_key(std::string_view key) {
  const auto parts = key_parts(key);
  std::string now;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const bool is_id = i + 1 == parts.size() || (i > 0 && parse_kind(parts[i - 1]));
    if (i > 0) now += '.';
    now += is_id && parts[i].find('-') != parts[i].npos ? current_id(parts[i]) : parts[i];
  }
  return now;
}

}  // namespace rubicon::model
