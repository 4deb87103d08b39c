#include "recording/each_item.h"

namespace rubicon::recording {

namespace {

constexpr std::size_t kPieceBytes = 64 << 10;

}  // namespace

Result<void> each_item(const ReadPiece& read, const VisitItem& visit) {
  RecordingReader reader;
  Bytes piece(kPieceBytes);
  while (!reader.ended()) {
    const auto count = read(piece);
    if (!count) return fail(count.error());
    if (*count == 0) reader.end();
    if (*count > 0) reader.feed(ByteView(piece).first(*count));
    while (const auto item = reader.next()) {
      if (auto visited = visit(*item); !visited) return visited;
    }
  }
  return {};
}

}  // namespace rubicon::recording
