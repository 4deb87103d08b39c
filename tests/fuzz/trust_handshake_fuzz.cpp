#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "fuzz_target.h"
#include "handshake_sample.h"

namespace rubicon::fuzz::trust_handshake_fuzz {

/// What a stranger says in a handshake, as samples of the two built-in readers for it: the first byte says how the
/// sample comes, the second how large its pieces are, the rest is its content.
FUZZ_TARGET(trust_handshake) {
  if (size < 2 + 4 || size > 65'000) return 0;
  rubicon_fuzz_sample sample{};
  sample.kind = (data[0] & 3U) % 3;
  sample.is_volatile = (data[0] & 4U) != 0;
  sample.way = static_cast<rubicon_fuzz_way>((data[0] >> 3U & 3U) % 3);
  sample.piece = std::max<std::size_t>(data[1] * std::size_t{4}, 4);
  sample.content = data + 2;
  sample.size = size - 2;
  const auto taken = rubicon_fuzz_take(&sample);
  if (sample.kind != 2 || sample.way == RUBICON_FUZZ_KEY_HASH) return 0;
  sample.way = RUBICON_FUZZ_PARTS;  // the pieces and the way do not change what is understood
  sample.piece = size;
  if (rubicon_fuzz_take(&sample) != taken) __builtin_trap();
  return 0;
}

}  // namespace rubicon::fuzz::trust_handshake_fuzz
