#include "tuples/member_ids.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>

namespace rubicon::tuples {

OwnerId random_id(const Member& member) {
  const auto largest = std::max_element(
      member.ids.begin(), member.ids.end(),
      [](const IdRange& one, const IdRange& other) { return one.last - one.first < other.last - other.first; });
  if (largest == member.ids.end()) return model::kNoOwner;
  std::random_device source;
  return OwnerId(std::uniform_int_distribution<std::uint32_t>(largest->first, largest->last)(source));
}

std::string text_of_ids(const Member& member) {
  std::string text;
  for (const auto& range : member.ids) {
    text += fmt::format("{}{:08x}", text.empty() ? "" : ", ", range.first);
    if (range.last != range.first) text += fmt::format("-{:08x}", range.last);
  }
  return text.empty() ? "none" : text;
}

}  // namespace rubicon::tuples
