#pragma once

#include <functional>
#include <span>

#include "recording/recording_reader.h"

namespace rubicon::recording {

/// Puts the next bytes of a file into the place and returns how many; 0 = the end.
using ReadPiece = std::function<Result<std::size_t>(std::span<std::uint8_t> into)>;
/// An item is valid during the call.
using VisitItem = std::function<Result<void>(const RecordingReader::Item& item)>;

/// Visits all that is in a file that does not grow, in its order. Ends with the first error of reading or visiting.
Result<void> each_item(const ReadPiece& read, const VisitItem& visit);

}  // namespace rubicon::recording
