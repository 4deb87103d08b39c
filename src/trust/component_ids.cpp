#include "trust/component_ids.h"

#include <fmt/format.h>

#include <random>

#include "rubicon/summary.hpp"

namespace rubicon::trust {

OwnerId random_id(const tuples::Member& member) {
  std::random_device source;
  for (const auto& one : member.ids) {
    if (one.first <= model::kMaxIslandId || one.last < one.first) continue;
    return OwnerId(std::uniform_int_distribution<std::uint32_t>(one.first, one.last)(source));
  }
  return OwnerId{};
}

std::string ids_text(const tuples::Member& member) {
  std::string text;
  for (const auto& one : member.ids) {
    if (!text.empty()) text += ", ";
    text += one.first == one.last ? std::to_string(one.first) : fmt::format("{:08x}-{:08x}", one.first, one.last);
  }
  return text;
}

}  // namespace rubicon::trust
