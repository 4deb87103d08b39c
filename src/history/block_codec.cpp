#include "history/block_codec.h"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>

#include "base/assert.h"

namespace rubicon::history {

namespace {

constexpr std::uint8_t kPlain = 0, kZstd = 1;
constexpr int kLevel = 3;

}  // namespace

BlockCodec::BlockCodec() : packer_(ZSTD_createCCtx(), ZSTD_freeCCtx), unpacker_(ZSTD_createDCtx(), ZSTD_freeDCtx) {
  RUBICON_ASSERT(packer_ && unpacker_);
  ZSTD_CCtx_setParameter(packer_.get(), ZSTD_c_compressionLevel, kLevel);
  ZSTD_CCtx_setParameter(packer_.get(), ZSTD_c_checksumFlag, 1);
}

BlockCodec::~BlockCodec() = default;

Bytes BlockCodec::close(ByteView plain) {
  Bytes out(1 + ZSTD_compressBound(plain.size()));
  const auto size = ZSTD_compress2(packer_.get(), out.data() + 1, out.size() - 1, plain.data(), plain.size());
  if (ZSTD_isError(size) == 0 && size < plain.size()) {
    out[0] = kZstd;
    out.resize(1 + size);
    return out;
  }
  out.resize(1 + plain.size());
  out[0] = kPlain;
  std::copy(plain.begin(), plain.end(), out.begin() + 1);
  return out;
}

Result<ByteView> BlockCodec::open(ByteView closed) {
  if (closed.empty() || closed[0] > kZstd) return fail(ErrorCode::kInvalid, "a block of unknown form");
  const auto rest = closed.subspan(1);
  if (closed[0] == kPlain) return rest;
  const auto length = ZSTD_getFrameContentSize(rest.data(), rest.size());
  // The two values for "unknown" and "error" are beyond it, too.
  if (length > kMaxPlain) return fail(ErrorCode::kInvalid, "a block of unknown length");
  plain_.resize(static_cast<std::size_t>(length));
  const auto size = ZSTD_decompressDCtx(unpacker_.get(), plain_.data(), plain_.size(), rest.data(), rest.size());
  if (ZSTD_isError(size) != 0 || size != plain_.size())
    return fail(ErrorCode::kInvalid, fmt::format("a damaged block of {} bytes", closed.size()));
  return ByteView(plain_);
}

Result<Points> BlockCodec::decode(ByteView bytes) {
  const auto plain = open(bytes);
  if (!plain) return fail(plain.error());
  return unpack_points(*plain);
}

}  // namespace rubicon::history
