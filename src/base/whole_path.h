#pragma once

#include <string>

namespace rubicon::base {

/// The path from the root, as programs in other folders find the file; without `.` and `..`.
std::string whole_path(const std::string& path);

}  // namespace rubicon::base
