#pragma once

#include <functional>
#include <optional>
#include <span>

#include "recording/file_head.h"

namespace rubicon::recording {

/// Reads a file at an offset; fewer bytes than asked for only at its end.
using ReadAt = std::function<Result<std::size_t>(std::uint64_t offset, std::span<std::uint8_t> into)>;

/// How far a file is sound that is to be continued.
struct FileTail {
  bool has_head = false;  ///< false: the file is empty, or has the beginning of a head
  FileHead head;
  std::uint64_t sound = 0;         ///< end of the last sound block, where the file must be cut off
  std::optional<WallTime> last{};  ///< when its last record was seen; nullopt = there is no sound block
};

/// A longer damaged tail, in bytes, does not come from a crash: it is not searched and not cut off.
inline constexpr std::uint64_t kMaxTail = 32 << 20;

/// Searches backwards from the end, so that it is fast for large files with a sound end. Limited in what it reads and
/// checks, whatever the file holds. kInvalid if the file is not a recording, its head is damaged or no sound block is
/// near its end; kUnsupported if it is of a newer version; otherwise the errors of `read`.
Result<FileTail> find_tail(std::uint64_t size, const ReadAt& read);

}  // namespace rubicon::recording
