#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "tuples/meta_tuple.h"

namespace rubicon::console {

/// One line of an answer, its members in the order they were given.
using Line = nlohmann::ordered_json;

/// The first word; `rest` loses it and the blanks around it.
std::string_view take_word(std::string_view& rest);

/// In front of a key: not this tuple, but the one its reference leads to.
inline constexpr std::string_view kArrow = "->";

/// `KEY` of the island or `OWNER:KEY`, without wildcards.
Result<tuples::TupleName> read_name(std::string_view text, OwnerId island);

/// `KEY@7`: the key loses its end, 7 is the answer. Without @ nothing.
Result<std::optional<std::uint64_t>> take_sequence(std::string_view& word);

}  // namespace rubicon::console
