#include "model/open_type.h"

#include <fmt/format.h>

#include <algorithm>

#include "rubicon/key.hpp"

namespace rubicon::model {

namespace {

constexpr std::size_t kLongestName = 40;

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
  if (name.size() <= kLongestName) return name;
  return fmt::format("{}_{:04x}", name.substr(0, kLongestName - 5), number);
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

}  // namespace rubicon::model
