#include "base/whole_path.h"

#include <filesystem>

namespace rubicon::base {

std::string whole_path(const std::string& path) {
  std::error_code error;
  const auto whole = std::filesystem::absolute(path, error);
  return error ? path : whole.lexically_normal().string();  // the folder of this process is gone
}

}  // namespace rubicon::base
