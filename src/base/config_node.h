#pragma once

#include <string>
#include <utility>
#include <vector>

namespace rubicon::base {

/// Where in a configuration file something stands; line and column count from 1, 0 = not from a file (`--set`).
struct ConfigPlace {
  std::string file;
  int line = 0;
  int column = 0;
};

/// `home.yaml:3:7`, or the file's name alone.
std::string to_string(const ConfigPlace& place);

/// A configuration tree as its author wrote it: text not yet interpreted, every node with its place.
struct ConfigNode {
  enum class Kind { kNull, kScalar, kList, kMap };

  Kind kind = Kind::kNull;
  ConfigPlace place;
  std::string text;                                         ///< of a scalar
  bool was_quoted = false;                                  ///< a quoted scalar is text, whatever it looks like
  std::vector<ConfigNode> items;                            ///< of a list
  std::vector<std::pair<std::string, ConfigNode>> entries;  ///< of a map, in the order of the file, keys unique

  // Defined out of line: clang needs the type complete before a pair of it.
  ConfigNode();
  ~ConfigNode();
  ConfigNode(const ConfigNode&);
  ConfigNode& operator=(const ConfigNode&);
  ConfigNode(ConfigNode&&) noexcept;
  ConfigNode& operator=(ConfigNode&&) noexcept;

  const ConfigNode* find(const std::string& key) const;
};

/// Where two trees say different things, as paths such as `devices.7.id`: at most `limit` of them, in the order of
/// `now`, then what only `before` has. Places, comments and the order of keys do not count; empty = they say the same.
std::vector<std::string> differences(const ConfigNode& before, const ConfigNode& now, std::size_t limit);

}  // namespace rubicon::base

namespace rubicon {
using base::ConfigNode;
using base::ConfigPlace;
}  // namespace rubicon
