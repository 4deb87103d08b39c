#pragma once

#include <cstddef>
#include <string>

#include "base/config_node.h"

namespace rubicon::config {

/// The tree as YAML for people and programs that read it over the tuple space: secrets are `****` (base/masked.h),
/// comments and anchors are gone. Short maps and lists stand on one line. Beyond `most` bytes it ends with a comment
/// that says so, after a whole line.
std::string yaml_text(const ConfigNode& root, std::size_t most);

}  // namespace rubicon::config
