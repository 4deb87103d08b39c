#pragma once

#include <functional>
#include <span>

#include "recording/file_head.h"

namespace rubicon::recording {

/// Reads a file at an offset; fewer bytes than asked for only at its end.
using ReadAt = std::function<Result<std::size_t>(std::uint64_t offset, std::span<std::uint8_t> into)>;

/// How far a file that is to be appended to is sound.
struct FileTail {
  bool has_head = false;  ///< false: nothing in it yet but, perhaps, the beginning of a head
  FileHead head;
  std::uint64_t sound = 0;  ///< end of the last sound block; what is behind it must be cut off
};

/// A tail longer than this, in bytes, is not what a crash leaves behind: it is not searched, and not cut off.
inline constexpr std::uint64_t kLongestTail = 32 << 20;

/// Looks from the end backwards, so that the size of the file does not matter while its end is sound; bounded in what
/// it reads and checks, whatever the file holds. kInvalid if it is no recording, its head is damaged or no sound block
/// is near its end, kUnsupported if it is of a newer version; else what `read` says.
Result<FileTail> find_tail(std::uint64_t size, const ReadAt& read);

}  // namespace rubicon::recording
