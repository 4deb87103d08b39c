#include "networks/knx/project/types.h"

#include <fmt/format.h>

#include <algorithm>

namespace rubicon::networks::knx::project {

namespace {

constexpr auto kMainOnly = dpt::DptId::kMainOnly;

std::optional<dpt::DptId> type_of_size(std::string_view size) {
  if (size == "1 Bit") return dpt::DptId{1, kMainOnly};
  if (size == "2 Bit") return dpt::DptId{2, kMainOnly};
  if (size == "4 Bit") return dpt::DptId{3, kMainOnly};
  return std::nullopt;
}

std::string list_text(const std::vector<dpt::DptId>& types) {
  constexpr std::size_t kShown = 6;
  std::string out;
  for (std::size_t i = 0; i < types.size() && i < kShown; ++i)
    out += fmt::format("{}{}", i == 0 ? "" : ", ", to_string(types[i]));
  return types.size() > kShown ? out + ", ..." : out;
}

}  // namespace

void add_type(std::vector<dpt::DptId>& types, dpt::DptId type) {
  if (types.size() < kMaxTypes && std::find(types.begin(), types.end(), type) == types.end()) types.push_back(type);
}

std::vector<dpt::DptId> object_types(std::string_view types, std::string_view size) {
  std::vector<dpt::DptId> all;
  while (true) {
    types.remove_prefix(std::min(types.find_first_not_of(" ,\n"), types.size()));
    if (types.empty()) break;
    const auto word = types.substr(0, types.find_first_of(" ,\n"));
    types.remove_prefix(word.size());
    const auto id = dpt::parse_dpt(word);
    const auto* known = id ? dpt::find_dpt(*id) : nullptr;
    if (known != nullptr) add_type(all, known->id.sub == kMainOnly ? known->id : *id);
  }
  if (const auto by_size = all.empty() ? type_of_size(size) : std::nullopt) all.push_back(*by_size);
  return all;
}

ChosenType type_of(std::optional<dpt::DptId> own, const std::vector<dpt::DptId>& of_objects) {
  if (own && own->sub != kMainOnly) return {own, {}};
  std::vector<dpt::DptId> types;
  for (const auto type : of_objects) {
    if (!own || type.main == own->main) add_type(types, type);
  }
  if (types.empty()) return {own, {}};
  if (types.size() == 1) return {types.front(), {}};
  const auto main = types.front().main;
  const bool one_main = std::all_of(types.begin(), types.end(), [&](dpt::DptId type) { return type.main == main; });
  if (own) return {own, {}};
  std::sort(types.begin(), types.end());
  if (one_main)
    return {dpt::DptId{main, kMainOnly},
            fmt::format("its objects have the types {}: imported with main type {}", list_text(types), main)};
  return {std::nullopt, fmt::format("its objects have the types {}: imported without a type", list_text(types))};
}

}  // namespace rubicon::networks::knx::project
