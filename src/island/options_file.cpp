#include "island/options_file.h"

#include <string.h>  // NOLINT(modernize-deprecated-headers): explicit_bzero

#include <filesystem>
#include <string_view>

#include "base/bytes.h"

namespace rubicon::island {

namespace {

std::size_t digest_of(const std::string& path, transport::Transports& transports) {
  auto file = transports.open_file(path);
  if (!file) return 0;
  std::size_t digest = 1;
  base::Bytes piece(65536);
  for (std::size_t total = 0; total < kLargestOptionsFile && digest != 0;) {
    const auto count = (*file)->read(piece);
    if (count && *count == 0) break;
    const auto text = base::as_text(base::ByteView(piece).first(count.value_or(0)));
    digest = count ? 31 * digest + std::hash<std::string_view>()(text) : 0;
    total += text.size();
  }
  ::explicit_bzero(piece.data(), piece.size());  // it may be a password
  return digest;
}

}  // namespace

FileDigests digests_of_options_files(const island::NetworkSetup& setup, const std::string& directory,
                                     transport::Transports& transports) {
  FileDigests digests;
  if (!setup.type) return digests;
  for (const auto name : setup.type->file_options) {
    const auto* option = setup.options.find(name);
    if (!option || option->text.empty()) continue;
    digests[std::string(name)] = digest_of((std::filesystem::path(directory) / option->text).string(), transports);
  }
  return digests;
}

std::vector<std::string> changed_files(const FileDigests& before, const FileDigests& now) {
  std::vector<std::string> changed;
  for (const auto& [name, digest] : now) {
    const auto known = before.find(name);
    if (known == before.end() ? digest == 0 : known->second == digest) continue;
    changed.push_back(name.ends_with("-file") ? name : name + " file");
  }
  return changed;
}

}  // namespace rubicon::island
