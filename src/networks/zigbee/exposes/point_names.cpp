#include "networks/zigbee/exposes/point_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "model/point.h"
#include "model/type_names.h"
#include "networks/zigbee/exposes/type_table.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::zigbee::exposes {

namespace {

constexpr std::size_t kMaxTypeName = 200;  ///< messages take 255
constexpr std::size_t kMaxNameText = 40;   ///< of an instance in keys (proxy/naming.cpp)
constexpr std::size_t kMaxProperty = 64;   ///< the instance of a property: the id of a sensor or actuator

std::string_view form_word(LeafForm form) {
  switch (form) {
    case LeafForm::kNumeric: return "numeric";
    case LeafForm::kBinary: return "binary";
    case LeafForm::kEnum: return "enum";
    case LeafForm::kText: return "text";
    case LeafForm::kList: return "list";
    case LeafForm::kComposite: return "composite";
  }
  return "";
}

bool is_colour(std::string_view name) {
  return name == "color_xy" || name == "color_hs";
}

/// Parts that are not empty, with `-` between them.
std::string joined_parts(std::string_view one, std::string_view other) {
  if (one.empty() || other.empty()) return std::string(one.empty() ? other : one);
  return fmt::format("{}-{}", one, other);
}

std::string id_of(const Capability& capability, std::string_view instance) {
  return joined_parts(model::name_in_keys(capability), instance);
}

/// Smaller = more the endpoint's own: actuators before sensors, types of the catalogue in the order of the table.
std::tuple<bool, std::ptrdiff_t> rank_of(const Capability& capability) {
  const auto rows = type_rows();
  const auto row =
      std::find_if(rows.begin(), rows.end(), [&](const TypeRow& one) { return one.type == capability.type_name; });
  return {capability.point.kind != Kind::kActuator, row - rows.begin()};
}

/// The id of the point of each endpoint that its properties belong to; endpoints with properties only have none.
std::map<std::string_view, std::string> owners_of(const std::vector<Leaf>& leaves,
                                                  const std::vector<MappedPoint>& points) {
  using Rank = decltype(rank_of(points[0].capability));
  std::map<std::string_view, std::pair<Rank, const Capability*>> best;
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const auto& one = points[i].capability;
    if (leaves[i].endpoint.empty() || one.point.kind == Kind::kProperty) continue;
    const std::pair candidate{rank_of(one), &one};
    const auto [owner, first] = best.try_emplace(leaves[i].endpoint, candidate);
    if (!first && candidate.first < owner->second.first) owner->second = candidate;
  }
  std::map<std::string_view, std::string> owners;
  for (const auto& [endpoint, owner] : best)
    owners.emplace(endpoint, id_of(*owner.second, owner.second->point.instance));
  return owners;
}

}  // namespace

std::string_view own_property(const Leaf& leaf) {
  std::string_view property = leaf.property;
  const auto& endpoint = leaf.endpoint;
  if (!endpoint.empty() && property.size() > endpoint.size() + 1 && property.ends_with(endpoint) &&
      property[property.size() - endpoint.size() - 1] == '_')
    property.remove_suffix(endpoint.size() + 1);
  const bool of_group = !leaf.group.empty() && property.size() == leaf.group.size() + 1 + leaf.name.size() &&
                        property.starts_with(leaf.group) && property.ends_with(leaf.name);
  const bool same = of_group || (is_colour(leaf.name) && property == "color") ||
                    model::plain_word(property) == model::plain_word(leaf.name);  // `breezeMode` of `breeze mode`
  return same ? std::string_view(leaf.name) : property;
}

std::string open_name(const Leaf& leaf, const TypeCatalogue& types) {
  auto name = leaf.name.size() <= kMaxTypeName ? leaf.name : model::to_key_part(leaf.name, kMaxTypeName);
  Capability capability;
  capability.type_name = name;
  if (types.find(model::name_in_keys(capability)) != nullptr) name += fmt::format("_{}", form_word(leaf.form));
  return name;
}

std::string open_tag(const Leaf& leaf) {
  const auto property = own_property(leaf);
  return property == leaf.name ? std::string() : std::string(property);
}

TypeId PointNames::open_type_of(const std::string& name) {
  if (const auto known = open_.find(name); known != open_.end()) return known->second;
  auto number = static_cast<std::uint16_t>(model::open_type(name));
  while (!numbers_.insert(TypeId(number)).second)
    number = number + 1 < model::kFirstSiteType ? static_cast<std::uint16_t>(number + 1) : model::kFirstOpenType;
  return open_[name] = TypeId(number);
}

bool PointNames::take(const std::string& id) {
  ++tries_;
  return taken_.insert(id).second;
}

void PointNames::set_unique(const Leaf& leaf, std::string instance, std::size_t limit, Capability& capability) {
  const auto id = [&, kind = model::to_string(capability.point.kind)](std::string_view one) {
    return fmt::format("{}.{}", kind, id_of(capability, one));
  };
  bool fits = take(id(instance));
  if (!fits) {
    const auto property = model::to_key_part(leaf.property, limit / 2);
    instance = joined_parts(instance.substr(0, limit - property.size() - 1), property);
    fits = take(id(instance));
  }
  if (!fits) {
    const auto beginning = instance.substr(0, limit - 6);
    auto& last = last_numbers_.try_emplace(id(beginning), 1).first->second;
    do instance = fmt::format("{}-{}", beginning, ++last);
    while (!take(id(instance)));
  }
  capability.point.instance = std::move(instance);
}

void PointNames::name(const Leaf& leaf, std::string_view tag, Capability& capability) {
  tags_.emplace_back(tag);
  const bool property = capability.point.kind == Kind::kProperty;
  if (property && !leaf.endpoint.empty()) return;
  auto instance = joined_parts(leaf.endpoint, tag);
  if (instance.empty() && !property) instance = "1";
  const auto limit = property ? kMaxProperty : kMaxNameText;
  if (!instance.empty()) instance = model::to_key_part(instance, limit);
  set_unique(leaf, std::move(instance), limit, capability);
}

void PointNames::name_properties(const std::vector<Leaf>& leaves, std::vector<MappedPoint>& points) {
  const auto owners = owners_of(leaves, points);
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    auto& capability = points[i].capability;
    const auto& endpoint = leaves[i].endpoint;
    if (capability.point.kind != Kind::kProperty || endpoint.empty()) continue;
    const auto owner = owners.find(endpoint);
    const auto instance =
        joined_parts(owner == owners.end() ? model::to_key_part(endpoint, kMaxNameText) : owner->second, tags_[i]);
    set_unique(leaves[i], model::to_key_part(instance, kMaxProperty), kMaxProperty, capability);
  }
}

}  // namespace rubicon::networks::zigbee::exposes
