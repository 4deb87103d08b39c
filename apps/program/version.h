#pragma once

#include <string>

namespace rubicon::program {

/// What --version prints: `PROGRAM VERSION`, the commit that was built, and each library that this process has loaded,
/// with its version: the loaded one's where the library tells it, else that of the build. Ends without a line feed.
std::string version_text(const char* program);

}  // namespace rubicon::program
