#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"

namespace rubicon::networks::zigbee::exposes {

/// Levels of brackets in JSON of devices and definitions (zigbee.md, section 3.1: composites may nest).
inline constexpr std::size_t kDeepestJson = 32;

/// Forms of a leaf in the grammar of `exposes` (zigbee.md, section 3.1).
enum class LeafForm : std::uint8_t { kNumeric, kBinary, kEnum, kText, kList, kComposite };

/// Category of a leaf: absent = the main function of the device.
enum class Category : std::uint8_t { kMain, kConfig, kDiagnostic };

/// Bits of `access`: the property appears in the published state, can be set, can be read by `get`.
struct LeafAccess {
  bool published = false, settable = false, gettable = false;
  friend bool operator==(const LeafAccess&, const LeafAccess&) = default;
};

/// A word that a leaf names: a value of an enumeration or of a binary, or a preset. JSON permits any scalar here.
struct NamedValue {
  std::string name;  ///< as people read it
  std::string json;  ///< as it stands in state and set: `"ON"`, `true`, `3`
  friend bool operator==(const NamedValue&, const NamedValue&) = default;
};

/// A leaf of the `exposes` of a definition: one property of a device in its state messages.
struct Leaf {
  LeafForm form = LeafForm::kNumeric;
  std::string group;     ///< `light`, `cover`, ...: the group that it stands in; empty = none
  std::string name;      ///< the meaning: `temperature`
  std::string property;  ///< the JSON key in state and set: `temperature`, `state_left`
  std::string endpoint;  ///< `left`; empty = none
  std::string label, unit;
  LeafAccess access;
  Category category = Category::kMain;
  std::optional<double> minimum, maximum, step;  ///< of a numeric
  NamedValue on, off;                            ///< of a binary
  std::vector<NamedValue> values;                ///< of an enumeration; the presets of a numeric
  std::vector<Leaf> features;                    ///< the parts of a composite; the item of a list
  std::string part;                              ///< of a leaf that siren_leaves() made: the part that it sets
  friend bool operator==(const Leaf&, const Leaf&) = default;
};

/// Reads the `exposes` array of a definition; groups are flattened. What is not a leaf (no property, unknown type,
/// access 0) is skipped and described in `skipped`. kInvalid if the text is no JSON array; nesting and numbers of
/// leaves are bounded.
Result<std::vector<Leaf>> read_exposes(std::string_view json, std::vector<std::string>& skipped);

}  // namespace rubicon::networks::zigbee::exposes
