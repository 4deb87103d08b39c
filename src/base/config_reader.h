#pragma once

#include <cstdint>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rubicon/time.hpp"

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

namespace rubicon::base {

/// All errors of a configuration, each line `file:line:column: path: what, expected what`.
class ConfigErrors {
 public:
  void add(const ConfigPlace& place, std::string_view path, std::string_view text);
  bool empty() const { return lines_.empty(); }
  const std::vector<std::string>& lines() const { return lines_; }
  /// The lines joined by newlines.
  std::string text() const;

 private:
  std::vector<std::string> lines_;
};

/// Reads one map of a configuration: each getter takes a key, checks its value and remembers that the key is known;
/// finish() reports the unknown ones. A wrong value is reported and replaced by the default, so that one run finds all.
/// The node and the errors must outlive it.
class ConfigReader {
 public:
  ConfigReader(const ConfigNode& map, std::string path, ConfigErrors& errors);

  bool has(const std::string& key) const;
  std::string text(const std::string& key, std::string_view otherwise);
  /// Reports a missing key.
  std::string required_text(const std::string& key, std::string_view expected = {});
  std::string choice(const std::string& key, std::string_view otherwise, std::initializer_list<std::string_view> words);
  bool boolean(const std::string& key, bool otherwise);
  std::int64_t integer(const std::string& key, std::int64_t otherwise,
                       std::int64_t minimum = std::numeric_limits<std::int64_t>::min(),
                       std::int64_t maximum = std::numeric_limits<std::int64_t>::max());
  double real(const std::string& key, double otherwise, double minimum = -std::numeric_limits<double>::max(),
              double maximum = std::numeric_limits<double>::max());
  /// `250ms`, `5s`, `1.5h`, `2min`, `1d`; the unit is required.
  Duration duration(const std::string& key, Duration otherwise);
  /// Same, or the word `never` (nullopt).
  std::optional<Duration> duration_or_never(const std::string& key, std::optional<Duration> otherwise);
  /// Bytes: `100MB`, `64KiB`, `1.5GB`, `512B`; the unit is required.
  std::uint64_t size(const std::string& key, std::uint64_t otherwise, std::uint64_t minimum = 0,
                     std::uint64_t maximum = std::numeric_limits<std::uint64_t>::max());

  /// The node of a key, for reading by the caller (marked as known); nullptr if absent.
  const ConfigNode* node(const std::string& key);
  /// A nested map; an empty one if absent, an error if not a map.
  ConfigReader map(const std::string& key);
  /// The entries of a nested map, each with a reader; empty if absent.
  std::vector<std::pair<std::string, ConfigReader>> maps(const std::string& key);
  /// A list of scalars; a single scalar counts as a list of one.
  std::vector<std::string> texts(const std::string& key);
  /// A list of maps.
  std::vector<ConfigReader> list(const std::string& key);
  /// All keys of this map, in file order (does not mark them as known).
  std::vector<std::string> keys() const;

  /// Adds an error about a key of this map (or about the map itself, if the key is empty).
  void error(const std::string& key, std::string_view text);
  /// Keys of this map that another reader reads: listed among the known ones.
  void also_known(std::span<const std::string_view> keys);
  /// Reports each key that was not read, with the nearest known key first, then all known ones.
  void finish();

  const ConfigNode& here() const { return *map_; }
  const std::string& path() const { return path_; }
  ConfigErrors& errors() { return *errors_; }

 private:
  const ConfigNode* scalar(const std::string& key);
  std::string path_of(const std::string& key) const;

  const ConfigNode* map_;
  std::string path_;
  ConfigErrors* errors_;
  std::set<std::string> known_;
};

/// `250ms`, `5s`, ...: nullopt if it is not a duration.
std::optional<Duration> parse_duration(std::string_view text);

/// Bytes in `100MB`, `64KiB`, ... (B; kB, MB, GB, TB by thousands; KiB, MiB, GiB, TiB by 1024): nullopt if it is not a
/// size.
std::optional<std::uint64_t> parse_size(std::string_view text);
/// The shortest exact form: `100MB`.
std::string size_text(std::uint64_t bytes);

}  // namespace rubicon::base

namespace rubicon {

using base::ConfigErrors;
using base::ConfigReader;

}  // namespace rubicon
