#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "model/words.h"
#include "networks/knx/dpt/dpt.h"
#include "networks/knx/wire/telegram.h"

namespace rubicon::networks::knx::groups {

/// Names of scenes by their number, from 1 to 64 as ETS and panels show it (0 to 63 on the wire: KNX 3/7/2, DPT 17).
using SceneNames = std::map<std::uint8_t, std::string>;

/// The catalogue's type of a point whose scenes have names: an enumeration with the words of the point.
inline constexpr TypeId kNamedScene{0x0280};
inline constexpr std::uint8_t kMostScenes = 64;
/// Added to the number of a scene: it is stored, not recalled. Bit 7 of 18.001 on the wire.
inline constexpr std::uint32_t kStores = 128;

/// True for 17.001 (recall) and 18.001 (recall and store).
bool has_scenes(dpt::DptId type);
/// What is wrong with the name of a scene; empty if it can be one: it must differ from numbers and from `store ...`.
std::string_view scene_name_fault(std::string_view name);

/// The words of a point: `evening` (1), and for 18.001 `store evening` (129) and `store 5` (133) for those without a
/// name. Sorted by value.
std::vector<model::Word> scene_words(dpt::DptId type, const SceneNames& names);
/// The highest number: 64, with 18.001 192 (128 + 64: the last one is stored).
std::uint32_t most_scene_number(dpt::DptId type);

/// The word of a payload of one byte, else its number.
Value scene_value(dpt::DptId type, const std::vector<model::Word>& words, std::uint8_t byte);
/// The payload of a word or number. kInvalid, kOutOfRange.
Result<wire::Payload> scene_payload(dpt::DptId type, const std::vector<model::Word>& words, const Value& value);

}  // namespace rubicon::networks::knx::groups
