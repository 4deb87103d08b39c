#include "base/text.h"

#include <filesystem>

namespace rubicon::base {

std::string resolve_path(std::string_view directory, std::string_view path) {
  return (std::filesystem::path(directory) / path).string();
}

}  // namespace rubicon::base
