#include "config/network_numbers.h"

#include <fmt/format.h>

#include <map>
#include <utility>

namespace rubicon::config {

void number_networks(ConfigNode& root) {
  auto* networks = root.find("networks");
  if (!networks || networks->kind != ConfigNode::Kind::kList) return;
  std::map<std::string, std::size_t> numbers;
  std::size_t place = 0;
  for (auto& item : std::exchange(networks->items, {})) {
    ++place;
    const auto* type = std::as_const(item).find("type");
    const bool typed = type && !type->text.empty();
    auto id = typed ? fmt::format("{}-{}", type->text, ++numbers[type->text]) : fmt::format("network-{}", place);
    networks->entries.emplace_back(std::move(id), std::move(item));
  }
  networks->kind = ConfigNode::Kind::kMap;
}

}  // namespace rubicon::config
