#pragma once

#include <span>
#include <string_view>

#include "networks/zigbee/exposes/leaf.h"

namespace rubicon::networks::zigbee::exposes {

/// Which leaves a row is for: those that only report, those that can be set, or both.
enum class Use : std::uint8_t { kAny, kRead, kSet };

/// How a number becomes one in the unit of the type, besides the conversion of units.
enum class Scale : std::uint8_t {
  kSame,
  kShare,     ///< share of value_max in percent: brightness 0..254
  kClosed,    ///< 100 % - number: Zigbee2MQTT reports how far a cover is open, the catalogue how far it is closed
  kFraction,  ///< 0..1 in percent
};

/// One row of the table: leaves on the left, the type of the catalogue on the right.
struct TypeRow {
  std::string_view group;  ///< of the leaf; empty = none, `*` = any or none
  std::string_view name;   ///< of the leaf; one `*` stands for any text, which becomes the instance of the point
  LeafForm form;
  std::string_view unit;  ///< UCUM code of the leaf's unit (units.h); empty = without unit
  Use use;
  std::string_view type;      ///< name in the catalogue
  std::string_view instance;  ///< of the point, instead of `1`; empty = `1` or the text of the `*`
  Scale scale = Scale::kSame;
  /// Where the type has words, its words and those of the leaf: `fan=fan_only,off=off`. The row holds for leaves whose
  /// words are all here. Of a boolean: `on=OPEN|OPENED`, the spellings that mean on whatever value_on says.
  std::string_view words{};
};

/// All rows; the first one that fits a leaf counts. Towards an MQTT bridge the first row of a type gives the leaf that
/// the type becomes.
std::span<const TypeRow> type_rows();

/// The row of a leaf, or nullptr; `name` stands for leaf.name, `code` is the code of its unit. `matched` becomes what
/// the `*` stands for.
const TypeRow* row_of(const Leaf& leaf, std::string_view group, std::string_view name, std::string_view code,
                      std::string_view& matched);
/// The first row of the type, or nullptr: the leaf that devices of this type have in `exposes`.
const TypeRow* row_of_type(std::string_view type);

/// The leaf's word of a row's `words`, for a word of the type; empty if it has none.
std::string_view leaf_word(const TypeRow& row, std::string_view type_word);
/// The word of the type for a word of the leaf; empty if it has none.
std::string_view type_word(const TypeRow& row, std::string_view leaf_word);

}  // namespace rubicon::networks::zigbee::exposes
