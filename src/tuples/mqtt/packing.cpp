#include "tuples/mqtt/packing.h"

#include <fmt/format.h>
#include <zstd.h>

#include "base/assert.h"

namespace rubicon::tuples::mqtt {

namespace {

/// The first byte of ZSTD_MAGICNUMBER as it is sent (RFC 8878, 3.1.1).
constexpr std::uint8_t kFirstByte = ZSTD_MAGICNUMBER & 0xff;
/// Of what is sent once the time matters more than the last tenth of its size.
constexpr int kFastest = 1;

}  // namespace

Packing::Packing() : packer_(ZSTD_createCCtx(), ZSTD_freeCCtx), unpacker_(ZSTD_createDCtx(), ZSTD_freeDCtx) {
  RUBICON_ASSERT(packer_ && unpacker_);
}

Packing::~Packing() = default;

std::optional<Bytes> Packing::packed(ByteView entries) {
  if (entries.size() < kMinPacked || entries.size() > kMaxUnpacked) return std::nullopt;
  Bytes out(ZSTD_compressBound(entries.size()));
  const auto size = ZSTD_compressCCtx(packer_.get(), out.data(), out.size(), entries.data(), entries.size(), kFastest);
  if (ZSTD_isError(size) != 0 || size >= entries.size()) return std::nullopt;
  out.resize(size);
  return out;
}

Result<ByteView> Packing::unpacked(ByteView received, Bytes& into) {
  if (received.empty() || received[0] != kFirstByte) return received;
  const auto length = ZSTD_getFrameContentSize(received.data(), received.size());
  // The two values for "unknown" and "error" are beyond it, too.
  if (length > kMaxUnpacked) return fail(ErrorCode::kInvalid, "packed entries of unknown or excessive size");
  into.resize(static_cast<std::size_t>(length));
  const auto size = ZSTD_decompressDCtx(unpacker_.get(), into.data(), into.size(), received.data(), received.size());
  if (ZSTD_isError(size) != 0 || size != into.size())
    return fail(ErrorCode::kInvalid, fmt::format("{} bytes of packed entries are damaged", received.size()));
  return ByteView(into);
}

}  // namespace rubicon::tuples::mqtt
