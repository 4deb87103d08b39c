#pragma once

#include <span>
#include <string_view>

namespace rubicon::cli {

/// What to do about a finding (model/findings.h).
struct Remedy {
  std::string_view finding, fix;
  std::string_view page;             ///< of the documentation, where it has more
  std::string_view for_broker = {};  ///< what to do at the broker of sites, if that is something else
};

/// nullptr: nothing more is known than the text beside the finding.
const Remedy* remedy_of(std::string_view finding);
/// All, each finding once.
std::span<const Remedy> remedies();

}  // namespace rubicon::cli
