#pragma once

#include "config/engine_config.h"

namespace rubicon::config {

/// Reads `carry` of `tuples`: what the island `own` (0 = not known) carries between its engines, which were read
/// before.
void read_carry(ConfigReader& tuples, std::uint32_t own, EngineSetup& engine);
/// The same of `tuples.peis`, as earlier releases have it: between dds and peis.
void read_carry_of_peis(ConfigReader& peis, std::uint32_t own, EngineSetup& engine);

/// `4711 and kitchen.** from dds to mqtt`, one text for each rule.
std::vector<std::string> carried(const tuples::carry::CarryRules& rules);

}  // namespace rubicon::config
