#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace rubicon::structure {

struct SourceFile {
  std::string path;  ///< from the root of the project, with slashes
  std::string text;
};

/// The root of the project that is looked at: another copy if the environment names it.
inline std::filesystem::path root_folder() {
  const char* tree = std::getenv("RUBICON_TREE");  // NOLINT(concurrency-mt-unsafe): one thread
  return tree != nullptr ? tree : RUBICON_SOURCE_DIR;
}

inline std::string read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// All files with one of these endings below a folder of the project.
inline std::vector<SourceFile> files_below(const std::string& folder, const std::vector<std::string>& endings) {
  namespace fs = std::filesystem;
  std::vector<SourceFile> files;
  const fs::path root = root_folder();
  if (!fs::exists(root / folder)) return files;
  for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
    if (!entry.is_regular_file()) continue;
    for (const auto& ending : endings) {
      if (entry.path().extension() == ending) {
        files.push_back({fs::relative(entry.path(), root).generic_string(), read_text(entry.path())});
      }
    }
  }
  return files;
}

/// All that programs and their users compile.
inline std::vector<SourceFile> product_sources() {
  std::vector<SourceFile> all;
  for (const auto* folder : {"include", "src", "apps"}) {
    for (auto& file : files_below(folder, {".h", ".hpp", ".cpp"})) all.push_back(std::move(file));
  }
  return all;
}

}  // namespace rubicon::structure
