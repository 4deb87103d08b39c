#include "proxy/commander.h"

#include <fmt/format.h>

#include <algorithm>

#include "rubicon/summary.hpp"

namespace rubicon::proxy {

namespace {

constexpr std::size_t kLongest = 60;

/// Of a foreign summary, for logs.
std::string printable(std::string text) {
  if (text.size() > kLongest) text.resize(kLongest);
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return text;
}

std::string island_name(std::string name, OwnerId id) {
  return name.empty() ? fmt::format("island {}", number(id)) : fmt::format("{} (island {})", name, number(id));
}

}  // namespace

std::string commander_name(const Surroundings& around, OwnerId id) {
  if (id == around.space.self()) return island_name(around.config.island_name, id);
  const auto text = around.space.summary(id);
  const auto summary = text.empty() ? model::Summary{} : model::summary_from_json(text).value_or(model::Summary{});
  const auto name = printable(summary.name);
  if (model::is_island(id)) return island_name(name, id);
  if (name.empty()) return fmt::format("component {}", number(id));
  const bool elsewhere = !summary.host.empty() && summary.host != around.config.host;
  const auto program = summary.program.empty() ? fmt::format("component {}", number(id)) : printable(summary.program);
  return fmt::format("{} ({}{}{})", name, program, elsewhere ? " on " : "", elsewhere ? printable(summary.host) : "");
}

}  // namespace rubicon::proxy
