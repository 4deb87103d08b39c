#include <fmt/format.h>

#include "model/message_fields.h"

namespace rubicon::model {

namespace {

constexpr int kMaxDepth = 8;

/// Walks a CBOR item (RFC 8949, section 3) without building it: lengths fit, nesting is shallow, text keys only. The
/// form uses definite lengths and no tags, so anything else is refused before a parser sees it.
class CborWalk {
 public:
  explicit CborWalk(ByteView bytes) : in_(bytes) {}

  bool item(int depth) {
    const auto first = in_.u8();
    const auto major = first >> 5;
    const auto argument = length(first & 31U);
    if (!in_.ok() || depth > kMaxDepth) return false;
    switch (major) {
      case 0: return true;
      case 1: return argument <= std::uint64_t{INT64_MAX};  // the parser would wrap round below -2^63
      case 2:
      case 3: return take(argument);
      case 4: return items(argument, depth, false);
      case 5: return items(argument, depth, true);
      case 7: return (first & 31U) >= 20 && (first & 31U) <= 27 && (first & 31U) != 24;
      default: return false;
    }
  }

  bool at_end() const { return in_.ok() && in_.remaining() == 0; }
  std::size_t position() const { return in_.position(); }

 private:
  std::uint64_t length(unsigned low) {
    if (low < 24) return low;
    switch (low) {
      case 24: return in_.u8();
      case 25: return in_.u16_be();
      case 26: return in_.u32_be();
      case 27: return in_.u64_be();
      default: in_.take(in_.remaining() + 1); return 0;  // indefinite or reserved: not in our form
    }
  }

  bool take(std::uint64_t count) {
    if (count > in_.remaining()) return false;
    in_.skip(static_cast<std::size_t>(count));
    return true;
  }

  bool items(std::uint64_t count, int depth, bool map) {
    if (count > in_.remaining()) return false;  // each takes at least a byte
    for (; count > 0; --count) {
      if (map && !text_key()) return false;
      if (!item(depth + 1)) return false;
    }
    return true;
  }

  bool text_key() {
    const auto first = in_.u8();
    return in_.ok() && first >> 5 == 3 && take(length(first & 31U)) && in_.ok();
  }

  base::ByteReader in_;
};

}  // namespace

Result<void> check_cbor(ByteView bytes) {
  CborWalk walk(bytes);
  if (walk.item(0) && walk.at_end()) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("message: not CBOR of definite lengths, text keys and at most {} levels, at byte {} of {}",
                          kMaxDepth, walk.position(), bytes.size()));
}

}  // namespace rubicon::model
