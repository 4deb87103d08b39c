#include "networks/knx/groups/scenes.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "model/value.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::knx::groups {

namespace {

constexpr std::string_view kStore = "store ";
constexpr std::size_t kMostNameBytes = 64;
constexpr std::uint8_t kNumberBits = 0x3f, kStoreBit = 0x80;

bool stores(dpt::DptId type) {
  return type.main == 18;
}

}  // namespace

bool has_scenes(dpt::DptId type) {
  return type.main == 17 || type.main == 18;
}

std::string_view scene_name_fault(std::string_view name) {
  if (name.empty() || name.size() > kMostNameBytes) return "expected a name of 1 to 64 bytes";
  if (model::plain_word(name).empty()) return "expected a name with a letter or digit";
  if (base::parse_number<double>(name)) return "expected a name, which is no number";
  const auto first = name.substr(0, kStore.size());
  if (model::same_word(first, kStore)) return "expected a name that does not begin with 'store'";
  return {};
}

std::vector<model::Word> scene_words(dpt::DptId type, const SceneNames& names) {
  std::vector<model::Word> words;
  for (const auto& [number, name] : names) words.push_back({number, name});
  for (std::uint32_t number = 1; stores(type) && number <= kMostScenes; ++number) {
    const auto name = names.find(static_cast<std::uint8_t>(number));
    words.push_back(
        {kStores + number, std::string(kStore) + (name == names.end() ? std::to_string(number) : name->second)});
  }
  return words;
}

std::uint32_t most_scene_number(dpt::DptId type) {
  return stores(type) ? kStores + kMostScenes : kMostScenes;
}

Value scene_value(dpt::DptId type, const std::vector<model::Word>& words, std::uint8_t byte) {
  const bool is_stored = stores(type) && (byte & kStoreBit) != 0;
  const auto number = (byte & kNumberBits) + 1U + (is_stored ? kStores : 0U);
  const auto word = std::find_if(words.begin(), words.end(), [&](const auto& one) { return one.value == number; });
  return word == words.end() ? Value(std::int64_t{number}) : Value(word->text);
}

Result<wire::Payload> scene_payload(dpt::DptId type, const std::vector<model::Word>& words, const Value& value) {
  const auto* whole = std::get_if<std::int64_t>(&value);
  const auto* text = std::get_if<std::string>(&value);
  auto number = text ? model::value_of_word(words, *text) : std::nullopt;
  if (whole && *whole >= 0 && *whole <= most_scene_number(type)) number = static_cast<std::uint32_t>(*whole);
  const auto scene = number ? *number & (kStores - 1) : 0U;
  const bool is_stored = number && *number > kStores;
  if (scene < 1 || scene > kMostScenes || *number > most_scene_number(type))
    return fail(
        text ? ErrorCode::kInvalid : ErrorCode::kOutOfRange,
        fmt::format("{} is no scene, expected a name or a number from 1 to {}{}", model::quoted(model::to_text(value)),
                    kMostScenes, stores(type) ? ", or 'store' and one of both" : ""));
  return wire::Payload{{static_cast<std::uint8_t>((scene - 1) | (is_stored ? kStoreBit : 0U))}, false};
}

}  // namespace rubicon::networks::knx::groups
