#include "island/options_file.h"

#include <filesystem>
#include <string_view>

#include "base/bytes.h"

namespace rubicon::island {

std::size_t digest_of_options_file(const island::NetworkSetup& setup, const std::string& directory,
                                   transport::Transports& transports) {
  if (!setup.type || setup.type->file_option.empty()) return 0;
  const auto* option = setup.options.find(setup.type->file_option);
  if (!option || option->text.empty()) return 0;
  auto file = transports.open_file((std::filesystem::path(directory) / option->text).string());
  if (!file) return 0;
  std::size_t digest = 1;
  base::Bytes piece(65536);
  for (std::size_t total = 0; total < kLargestOptionsFile;) {
    const auto count = (*file)->read(piece);
    if (!count) return 0;
    if (*count == 0) break;
    digest = 31 * digest + std::hash<std::string_view>()(base::as_text(base::ByteView(piece).first(*count)));
    total += *count;
  }
  return digest;
}

}  // namespace rubicon::island
