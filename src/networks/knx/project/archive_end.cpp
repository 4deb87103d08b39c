#include "networks/knx/project/archive_end.h"

#include <algorithm>
#include <optional>
#include <string_view>

#include "base/bytes.h"

namespace rubicon::networks::knx::project {

namespace {

constexpr std::string_view kEnd = "PK\x05\x06", kLocator64 = "PK\x06\x07", kEnd64 = "PK\x06\x06";
constexpr std::size_t kEndSize = 22, kLocator64Size = 20, kEnd64Size = 56;
constexpr std::size_t kLongestComment = 0xffff;

/// A number, low byte first.
std::uint64_t number_at(ByteView bytes, std::size_t at, std::size_t size) {
  std::uint64_t value = 0;
  for (std::size_t i = size; i > 0; --i) value = value << 8U | bytes[at + i - 1];
  return value;
}

Result<Bytes> read_at(transport::FileSource& file, std::uint64_t at, std::size_t size) {
  if (auto moved = file.seek(at); !moved) return fail(moved.error());
  Bytes bytes(size);
  std::size_t done = 0;
  while (done < size) {
    const auto count = file.read(std::span(bytes).subspan(done));
    if (!count) return fail(count.error());
    if (*count == 0) break;
    done += *count;
  }
  bytes.resize(done);
  return bytes;
}

/// The claims of the record for large archives, if the locator before the end record at `at` leads to one.
Result<std::optional<ArchiveEnd>> end64_before(transport::FileSource& file, ByteView tail, std::size_t at) {
  if (at < kLocator64Size) return std::nullopt;
  const auto locator = tail.subspan(at - kLocator64Size, kLocator64Size);
  if (!base::as_text(locator).starts_with(kLocator64)) return std::nullopt;
  const auto record = read_at(file, number_at(locator, 8, 8), kEnd64Size);
  if (!record) return fail(record.error());
  if (record->size() < kEnd64Size || !base::as_text(*record).starts_with(kEnd64)) return std::nullopt;
  return ArchiveEnd{number_at(*record, 32, 8), number_at(*record, 40, 8)};
}

}  // namespace

Result<ArchiveEnd> read_archive_end(transport::FileSource& file) {
  constexpr std::size_t kTail = kLongestComment + kEndSize + kLocator64Size;
  const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(file.size(), kTail));
  const auto tail = read_at(file, file.size() - size, size);
  if (!tail) return fail(tail.error());
  const auto text = base::as_text(*tail);
  ArchiveEnd most;
  bool found = false;
  for (auto at = text.find(kEnd); at != text.npos; at = text.find(kEnd, at + 1)) {
    if (at + kEndSize > text.size()) break;
    found = true;
    const auto large = end64_before(file, *tail, at);
    if (!large) return fail(large.error());
    const auto claims = large->value_or(ArchiveEnd{number_at(*tail, at + 10, 2), number_at(*tail, at + 12, 4)});
    most = {std::max(most.entries, claims.entries), std::max(most.directory, claims.directory)};
  }
  if (!found) return fail(ErrorCode::kInvalid, "not a zip archive, or its end is missing");
  return most;
}

}  // namespace rubicon::networks::knx::project
