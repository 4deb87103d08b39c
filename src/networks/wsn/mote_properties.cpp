#include "networks/wsn/mote_properties.h"

#include <algorithm>

#include "base/assert.h"

namespace rubicon::networks::wsn {

namespace {

const model::DeviceType& mote_type() {
  const auto all = TypeCatalogue::device_types();
  const auto found = std::find_if(all.begin(), all.end(), [](const auto& type) { return type.name == "mote"; });
  RUBICON_ASSERT(found != all.end());
  return *found;
}

}  // namespace

void MoteProperties::declare(std::uint16_t mote, model::Join& join) const {
  for (const auto& property : mote_type().properties) {
    model::Capability capability;
    capability.point = {Kind::kProperty, types_.find(property.property)->id, {}};
    capability.type_name = property.property;
    capability.access = property.access;
    const auto known = masks_.find(mote);
    if (property.property == "mask" && known != masks_.end()) capability.initial = std::int64_t{known->second};
    join.capabilities.push_back(std::move(capability));
  }
}

model::Updates MoteProperties::set_mask(std::uint16_t mote, std::uint16_t mask) {
  masks_[mote] = mask;
  const model::PointId point{Kind::kProperty, types_.find("mask")->id, {}};
  return model::Updates{{{point, std::int64_t{mask}, {}}}};
}

}  // namespace rubicon::networks::wsn
