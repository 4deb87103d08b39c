#include "networks/zigbee/device/properties.h"

#include <algorithm>
#include <utility>

namespace rubicon::networks::zigbee::device {

namespace {

using Points = std::vector<exposes::MappedPoint>;

bool are_same(const Property& one, const Points& its_points, const Property& other, const Points& other_points) {
  return std::equal(one.points.begin(), one.points.end(), other.points.begin(), other.points.end(),
                    [&](std::size_t a, std::size_t b) { return its_points[a] == other_points[b]; });
}

}  // namespace

void Properties::set_points(const Points& before, const Points& points) {
  auto old = std::exchange(all_, {});
  const auto known = std::exchange(by_name_, {});
  add(points);
  for (auto& property : all_) {
    const auto found = known.find(property.name);
    if (found == known.end()) continue;
    auto& its_past = old[found->second];
    if (its_past.unproven || are_same(property, points, its_past, before))
      static_cast<KnownValue&>(property) = std::move(its_past);
  }
}

void Properties::add(const Points& points) {
  of_point_.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& point = points[i];
    const auto [entry, fresh] = by_name_.emplace(point.property, all_.size());
    if (fresh) {
      auto& property = all_.emplace_back();
      property.name = point.property;
      property.of_the_link = point.property == "linkquality";
    }
    auto& property = all_[entry->second];
    property.points.push_back(i);
    property.published |= point.access.published;
    property.settable |= point.access.settable;
    property.gettable |= point.access.gettable;
    property.event |= point.event;
    of_point_.push_back(entry->second);
  }
}

Property* Properties::find(std::string_view key) {
  const auto found = by_name_.find(key);
  return found == by_name_.end() ? nullptr : &all_[found->second];
}

}  // namespace rubicon::networks::zigbee::device
