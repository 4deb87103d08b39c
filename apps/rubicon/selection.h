#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rubicon/client.hpp"

namespace rubicon::cli {

/// Which tuples a text on the command line means. Islands know `*` for whole parts only; a `*` or `?` within a part
/// (`contact-*`) is applied by this program.
struct Selection {
  Pattern pattern;   ///< what islands understand; matches at least the selection
  std::string text;  ///< as it was typed, or what it is short for; for messages
  /// Of each part of the pattern, `*` where all fit; empty = the pattern alone decides.
  std::vector<std::string> globs{};

  bool fits(OwnerId owner, std::string_view key) const;
  /// The pattern matches more than the selection.
  bool narrower() const { return !globs.empty(); }
};
using Selections = std::vector<Selection>;

/// The text itself, and what it may be short for (`living.lamp-1`, `1_0_7.*`: the `last` of points); both also under
/// the names that types have today (model/former_types.h). No tuple fits two of them.
Result<Selections> parse_selections(std::string_view text, std::string_view last);
/// The same of several texts; of `otherwise` when there are none.
Result<Selections> parse_selections(const std::vector<std::string>& texts, const std::string& otherwise,
                                    std::string_view last);

bool any_fits(const Selections& selections, OwnerId owner, std::string_view key);

}  // namespace rubicon::cli
