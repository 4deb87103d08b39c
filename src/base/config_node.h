#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace rubicon::base {

/// A place in a configuration file; line and column count from 1, 0 = not from a file (`--set`).
struct ConfigPlace {
  ConfigPlace() = default;
  ConfigPlace(std::string_view of_file, int of_line, int of_column)
      : file(std::make_shared<const std::string>(of_file)), line(of_line), column(of_column) {}
  ConfigPlace(std::shared_ptr<const std::string> of_file, int of_line, int of_column)
      : file(std::move(of_file)), line(of_line), column(of_column) {}

  std::shared_ptr<const std::string> file;  ///< one name for all places of a file; nullptr = none
  int line = 0;
  int column = 0;
};

/// `home.yaml:3:7`, or the file's name alone.
std::string to_string(const ConfigPlace& place);

/// A configuration tree as written: texts are not interpreted yet, every node has its place.
struct ConfigNode {
  enum class Kind : std::uint8_t { kNull, kScalar, kList, kMap };

  Kind kind = Kind::kNull;
  bool was_quoted = false;  ///< a quoted scalar is always text
  ConfigPlace place;
  int key_line = 0, key_column = 0;                         ///< of an entry: place of its key; 0 = not known
  std::string text;                                         ///< of a scalar
  std::vector<ConfigNode> items;                            ///< of a list
  std::vector<std::pair<std::string, ConfigNode>> entries;  ///< of a map, in the order of the file, keys unique

  // Defined out of line: clang needs the type complete before a pair of it.
  ConfigNode();
  ~ConfigNode();
  ConfigNode(const ConfigNode&);
  ConfigNode& operator=(const ConfigNode&);
  ConfigNode(ConfigNode&&) noexcept;
  ConfigNode& operator=(ConfigNode&&) noexcept;

  const ConfigNode* find(std::string_view key) const;
  ConfigNode* find(std::string_view key);
  /// The place of the entry's key, or of the node if that is not known.
  ConfigPlace key_place() const;
};

/// The differences of two trees as paths such as `devices.7.id`: at most `limit` of them, in the order of `now`, then
/// what only `before` has. Places, comments and the order of keys do not count; empty = equal.
std::vector<std::string> differences(const ConfigNode& before, const ConfigNode& now, std::size_t limit);

/// A compact form of the tree without its places, about as long as its file, to be kept after reading.
std::string packed(const ConfigNode& node);
/// The tree that packed() was called with; for output of packed() only (asserted).
ConfigNode unpacked(std::string_view packed);

}  // namespace rubicon::base

namespace rubicon {
using base::ConfigNode;
using base::ConfigPlace;
}  // namespace rubicon
