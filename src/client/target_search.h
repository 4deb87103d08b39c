#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/names.h"
#include "rubicon/client.hpp"
#include "rubicon/tuple_space.hpp"
#include "tuples/meta_tuple.h"

// How a text that names one tuple is looked for (docs/cli.md#names-of-tuples): on the command line, in the shell of a
// daemon, and in the API.
namespace rubicon::client {

/// One tuple, or one of several owners that have it.
using Target = tuples::TupleName;

/// A name without wildcards as it was typed.
struct TypedTarget {
  std::optional<OwnerId> owner;
  std::string key;
};
Result<TypedTarget> parse_target(std::string_view text);

/// The pattern that a short name stands for: `living.lamp-1`, `dummy-rooms.living.lamp-1` and
/// `proxy.dummy-rooms.living.actuator.lamp-1`, with `last` (`value`, `command`) behind it. nullopt: it is not a short
/// name.
std::optional<Pattern> long_form(const TypedTarget& typed, std::string_view last);

/// `6541:lamp` for `home:lamp`; the same text where no island has that name, or several have it.
std::string with_island_id(const std::vector<IslandName>& islands, std::string_view text);

/// The islands among the components of a space, itself too.
std::vector<IslandName> islands_in(const TupleSpace& space);

/// Whether a text is to be looked for: it is not just the key of one tuple with its owner (`6541:GATEWAY`), nor can it
/// only be meant as one. Keys below the prefix of their island are keys, but for that of a point; so are those of what
/// is no island. False for patterns, and for what can name nothing.
bool is_name(const TupleSpace& space, std::string_view text);
/// The same where patterns are expected: without an owner a key means that of any island.
bool is_name_among_patterns(const TupleSpace& space, std::string_view text);

/// What was found.
struct Findings {
  std::vector<Target> targets{};
  std::vector<std::string> near{};  ///< of no target: what may have been meant
  bool is_read_only = false;        ///< of no target: `command` was asked for, and there is a `value`
};
/// The one that is meant. kNotFound, or kInvalid where several are: the text lists them.
Result<Target> the_one(const Findings& findings, std::string_view text);
/// At most ten of them, and how many more there are.
std::string listed(const std::vector<Target>& targets, std::string_view separator);

/// Looks for the present tuples that a text may mean: those with exactly this key, else those of the point that it is
/// short for, else those of the points that people call so (points_called()). `Living room.*` finds a pattern.
class TargetSearch {
 public:
  /// Gives the present tuples that match, at once or later. One read is under way at a time.
  using Read = std::function<void(const Pattern& pattern, TuplesCall call)>;
  /// kInvalid: the text is a pattern, or can name nothing.
  using Call = std::function<void(Result<Findings> findings)>;

  /// `last`: the last part of the keys of points, `value` or `command`.
  TargetSearch(std::vector<IslandName> islands, std::string text, std::string last, Read read, Call call);
  TargetSearch(const TargetSearch&) = delete;
  TargetSearch& operator=(const TargetSearch&) = delete;

  /// Calls once, perhaps before this returns; the call may destroy this.
  void start();

 private:
  void by_key();
  void by_name();
  void read_names();
  void read_points();
  void end(Result<Findings> findings);
  bool wants_command() const { return last_ == "command"; }

  std::string text_, last_;
  Read read_;
  Call call_;
  KnownNames names_;
  std::vector<Pattern> keys_{};    ///< that are tried before names
  std::vector<Pattern> points_{};  ///< that are called so
  std::size_t next_ = 0;           ///< of keys_, then of points_
  Findings found_{};
};

/// The tuples that tell what people call things: descriptions of devices, and what was arranged on the page.
std::vector<Pattern> name_patterns();
void add_names(const std::vector<Tuple>& tuples, KnownNames& names);

}  // namespace rubicon::client
