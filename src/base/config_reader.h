#pragma once

#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/config_node.h"
#include "rubicon/time.hpp"

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

/// Bytes in `100MB`, `64KiB`, ... (B; kB, MB, GB, TB by thousands; KiB, MiB, GiB, TiB by 1024): nullopt if it is no
/// size.
std::optional<std::uint64_t> parse_size(std::string_view text);
/// The shortest exact form: `100MB`.
std::string size_text(std::uint64_t bytes);

}  // namespace rubicon::base

namespace rubicon {
using base::ConfigErrors;
using base::ConfigReader;
}  // namespace rubicon
