#pragma once

#include <memory>
#include <optional>

#include "base/bytes.h"
#include "rubicon/result.hpp"

struct ZSTD_CCtx_s;
struct ZSTD_DCtx_s;

namespace rubicon::tuples::mqtt {

/// Makes the entries of large frames smaller: lists of devices shrink to less than a fifth. What is packed is one zstd
/// frame with its content size (RFC 8878), known by its first byte, with which no entry begins.
class Packing {
 public:
  Packing();
  ~Packing();

  /// The same in fewer bytes; nullopt: it stays as it is.
  std::optional<Bytes> packed(ByteView entries);
  /// The entries, in `into` if they were packed. kInvalid: damaged, or beyond kMaxUnpacked.
  Result<ByteView> unpacked(ByteView received, Bytes& into);

  /// Smaller ones would gain little.
  static constexpr std::size_t kMinPacked = 1024;
  /// The largest value and what goes with it.
  static constexpr std::size_t kMaxUnpacked = std::size_t{2} << 20;

 private:
  std::unique_ptr<ZSTD_CCtx_s, std::size_t (*)(ZSTD_CCtx_s*)> packer_;
  std::unique_ptr<ZSTD_DCtx_s, std::size_t (*)(ZSTD_DCtx_s*)> unpacker_;
};

}  // namespace rubicon::tuples::mqtt
