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

/// Looks from the end backwards, so that the size of the file does not matter while its end is sound. kInvalid if it is
/// no recording or its head is damaged, kUnsupported if it is of a newer version; else what `read` says.
Result<FileTail> find_tail(std::uint64_t size, const ReadAt& read);

}  // namespace rubicon::recording
