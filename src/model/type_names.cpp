#include "model/type_names.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

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

namespace {

constexpr std::size_t kMaxNameText = 40;

/// `off,on` of a boolean with two words; empty = the general ones.
std::string boolean_words(const Capability& capability) {
  const auto& words = capability.words;
  const auto has_comma = [](const Word& word) { return word.text.find(',') != word.text.npos; };
  if (capability.data != DataType::kBoolean || words.size() != 2 || std::ranges::any_of(words, has_comma)) return {};
  return words[0].text + ',' + words[1].text;
}

}  // namespace

std::string name_in_keys(const Capability& capability) {
  const auto number = static_cast<unsigned>(capability.point.type);
  if (capability.type_name.empty()) return fmt::format("type{}", number);
  auto name = to_key_part(capability.type_name, capability.type_name.size());
  // The first `-` of an id ends the type's name.
  std::ranges::replace(name, '-', '_');
  if (name.size() <= kMaxNameText) return name;
  return fmt::format("{}_{:04x}", name.substr(0, kMaxNameText - 5), number);
}

OpenType::OpenType(const Capability& capability)
    : name_(name_in_keys(capability)),
      unit_(capability.unit.empty() ? "1" : capability.unit),
      words_(boolean_words(capability)) {
  type_.id = capability.point.type;
  type_.name = name_;
  type_.unit = unit_;
  type_.data = capability.data.value_or(DataType::kText);
  type_.report = capability.report;
  type_.words = words_;
}

namespace {

constexpr std::string_view kRate = "rate";
constexpr std::size_t kKindAt = 3;

}  // namespace

std::string without_alias(std::string_view key) {
  if (key.find(kSamplingRate) == key.npos) return std::string(key);
  auto parts = key_parts(key);
  const bool whole = parts.size() > kKindAt + 1 && parts[kKindAt] == "property";
  const bool brief = parts.size() == 2 || parts.size() == 3;
  if (!whole && !brief) return std::string(key);
  auto& property = whole ? parts[kKindAt + 1] : parts.back();
  if (property == kSamplingRate) property = kRate;
  return fmt::format("{}", fmt::join(parts, "."));
}

}  // namespace rubicon::model
