#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace rubicon::cli {

/// Whether a counter of an island or a network counts losses, by the words of its name (`dropped-readings`,
/// `state-failures`), or because KNX Secure drops what it counts (is_secure_counter()).
bool counts_loss(std::string_view name);

/// Numbers by name.
using Counters = std::map<std::string, std::uint64_t>;
/// The properties that are whole numbers.
Counters counters_of(const std::map<std::string, std::string>& properties);
/// Those that count losses and are not zero.
Counters losses_of(const Counters& counters);
/// By how much each counter is higher than before; a counter that is lower began again from zero.
Counters growth_of(const Counters& before, const Counters& now);
/// `dropped-readings 12 (+3) bad-values 1`
std::string losses_text(const Counters& losses, const Counters& growth);

}  // namespace rubicon::cli
