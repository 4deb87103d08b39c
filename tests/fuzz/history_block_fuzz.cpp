#include <cstdlib>

#include "fuzz_target.h"
#include "history/blocks.h"

namespace rubicon::fuzz::history_block_fuzz {

namespace {

using history::BlockCodec;
using history::Points;

/// What is read can be written, and gives the same again.
void check(const Points& points, BlockCodec& codec) {
  if (points.size() > history::kMaxPoints) std::abort();
  for (const auto& point : points) {
    if (point.time < -history::kFurthest || point.time > history::kFurthest) std::abort();
  }
  const auto again = codec.decode(codec.encode(points));
  if (!again || *again != points) std::abort();
  auto rest = points;
  std::size_t taken = 0;
  for (const auto& block : history::take_blocks(rest, history::kBlockPoints)) {
    if (block.empty() || block.size() > history::kBlockPoints) std::abort();
    taken += block.size();
  }
  if (taken + rest.size() != points.size() || rest.size() >= history::kBlockPoints) std::abort();
}

}  // namespace

FUZZ_TARGET(history_block) {
  static BlockCodec codec;
  const ByteView bytes(data, size);
  if (const auto points = history::unpack_points(bytes)) check(*points, codec);
  if (const auto points = codec.decode(bytes)) check(*points, codec);
  return 0;
}

}  // namespace rubicon::fuzz::history_block_fuzz
