#pragma once

#include <memory>

#include "history/point_codec.h"

struct ZSTD_CCtx_s;
struct ZSTD_DCtx_s;

namespace rubicon::history {

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

}  // namespace rubicon::history
