#pragma once

#include <cstdint>
#include <span>

#include "base/bytes.h"
#include "history/point.h"

namespace rubicon::history {

/// Most points of one list, whatever a damaged file says.
inline constexpr std::size_t kMaxPoints = 65'536;

/// Packs points, loses nothing (docs/history.md#the-file). At most kMaxPoints.
Bytes pack_points(std::span<const Point> points);
/// kInvalid for what pack_points() did not write.
Result<Points> unpack_points(ByteView bytes);

/// Unsigned LEB128 and zigzag numbers, as in the lists of points.
void put_number(Bytes& out, std::uint64_t number);
void put_signed(Bytes& out, std::int64_t number);

/// Reads them, never beyond the end; after a failure all further ones are zero.
class NumberReader {
 public:
  explicit NumberReader(ByteView bytes) : bytes_(bytes) {}

  std::uint64_t number();
  std::int64_t signed_number();
  ByteView take(std::uint64_t count);
  bool ok() const { return ok_; }
  std::size_t remaining() const { return bytes_.size() - position_; }

 private:
  ByteView bytes_;
  std::size_t position_ = 0;
  bool ok_ = true;
};

}  // namespace rubicon::history
