#include "transport/read_text.h"

#include <fmt/format.h>

namespace rubicon::transport {

Result<std::string> read_text(Transports& transports, const std::string& path, std::size_t largest) {
  auto file = transports.open_file(path);
  if (!file) return fail(file.error());
  const auto too_large = [&](std::uint64_t size) {
    return fail(ErrorCode::kOutOfRange, fmt::format("{}: {} bytes, expected at most {}", path, size, largest));
  };
  if ((*file)->size() > largest) return too_large((*file)->size());
  std::string text;
  Bytes piece(65536);
  while (true) {
    const auto count = (*file)->read(piece);
    if (!count) return fail(count.error());
    if (*count == 0) return text;
    text += base::as_text(ByteView(piece).first(*count));
    if (text.size() > largest) return too_large(text.size());
  }
}

}  // namespace rubicon::transport
