#include "networks/zigbee/device/properties.h"

#include <utility>

namespace rubicon::networks::zigbee::device {

void Properties::set_points(const std::vector<exposes::MappedPoint>& points) {
  auto before = std::exchange(all_, {});
  const auto known = std::exchange(by_name_, {});
  of_point_.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& point = points[i];
    const auto [entry, fresh] = by_name_.emplace(point.property, all_.size());
    if (fresh) {
      const auto old = known.find(point.property);
      all_.push_back(old == known.end() ? Property{} : std::move(before[old->second]));
      auto& property = all_.back();
      property.name = point.property;
      property.points.clear();
      property.published = property.settable = property.gettable = property.event = false;
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
