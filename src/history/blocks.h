#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/bytes.h"
#include "history/series.h"

struct ZSTD_CCtx_s;
struct ZSTD_DCtx_s;

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

/// Packs lists of points and other bytes for the file: with zstd where that is shorter. Keeps the memory of zstd from
/// one call to the next.
class BlockCodec {
 public:
  BlockCodec();
  ~BlockCodec();

  Bytes encode(std::span<const Point> points) { return close(pack_points(points)); }
  /// kInvalid: damaged.
  Result<Points> decode(ByteView bytes);

  /// One byte that says whether zstd follows, then that or the bytes themselves.
  Bytes close(ByteView plain);
  /// kInvalid: damaged, or longer than kMaxPlain when unpacked. The view is valid until the next call.
  Result<ByteView> open(ByteView closed);
  static constexpr std::size_t kMaxPlain = 4 << 20;

 private:
  std::unique_ptr<ZSTD_CCtx_s, std::size_t (*)(ZSTD_CCtx_s*)> packer_;
  std::unique_ptr<ZSTD_DCtx_s, std::size_t (*)(ZSTD_DCtx_s*)> unpacker_;
  Bytes plain_;
};

/// A block spans at most this, so that a search for blocks knows how far back to begin.
inline constexpr std::int64_t kMaxBlockLength = kDay;
/// A block is closed so long after its first point at the latest.
inline constexpr std::int64_t kOpenBlock = 2 * kHour;
inline constexpr std::size_t kBlockPoints = 1024;

/// The points of one series that are not in a block yet. Keeps the older ones packed: ten thousand series have some
/// millions of them.
class OpenPoints {
 public:
  void add(const Point& point);
  void clear();
  bool empty() const { return count_ == 0; }
  std::size_t size() const { return count_; }
  /// Earliest and latest time; points may arrive in any order.
  std::int64_t start() const { return start_; }
  std::int64_t end() const { return end_; }
  const Point& last() const { return last_; }  ///< that arrived
  /// All of them, in the order of their arrival.
  Points all() const;

 private:
  std::vector<Bytes> packed_;
  Points tail_;
  std::size_t count_ = 0;
  std::int64_t start_ = 0, end_ = 0;
  Point last_;
};

/// Takes the points of complete blocks away from the beginning of `points`: each has at most `most` points within
/// kOpenBlock. What stays is not complete.
std::vector<Points> take_blocks(Points& points, std::size_t most);

}  // namespace rubicon::history
