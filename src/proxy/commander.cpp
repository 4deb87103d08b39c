#include "proxy/commander.h"

#include <fmt/format.h>

#include "base/printable.h"
#include "rubicon/summary.hpp"

namespace rubicon::proxy {

namespace {

constexpr std::size_t kMaxName = 60;

/// A text of a foreign summary, printable and cut after a character.
std::string shown_text(std::string_view text) {
  std::size_t end = 0;
  while (end < text.size()) {
    const auto length = base::first_character(text.substr(end)).size();
    if (end + length > kMaxName) break;
    end += length;
  }
  return base::printable(text.substr(0, end));
}

std::string island_name(std::string name, OwnerId id) {
  return name.empty() ? fmt::format("island {}", number(id)) : fmt::format("{} (island {})", name, number(id));
}

}  // namespace

std::string commander_name(const TupleSpace& space, const ProxyConfig& config, OwnerId id) {
  if (id == space.self()) return island_name(config.island_name, id);
  const auto text = space.summary(id);
  const auto summary = text.empty() ? model::Summary{} : model::summary_from_json(text).value_or(model::Summary{});
  const auto name = shown_text(summary.name);
  // A component without a summary has just appeared: its id is all that is known.
  if (model::is_island(id) && (text.empty() || !summary.prefix.empty())) return island_name(name, id);
  if (name.empty()) return fmt::format("component {}", number(id));
  const bool elsewhere = !summary.host.empty() && summary.host != config.host;
  const auto program = summary.program.empty() ? fmt::format("component {}", number(id)) : shown_text(summary.program);
  return fmt::format("{} ({}{}{})", name, program, elsewhere ? " on " : "", elsewhere ? shown_text(summary.host) : "");
}

}  // namespace rubicon::proxy
