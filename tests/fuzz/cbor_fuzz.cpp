#include <cstdlib>

#include "fuzz_target.h"
#include "model/message.h"

namespace rubicon::fuzz::cbor_fuzz {

/// Input: a message as it stands in a GATEWAY tuple. What was read must be written so that it reads as the same again.
FUZZ_TARGET(cbor) {
  using namespace rubicon;
  const auto message = model::from_cbor({data, size});
  if (!message) {
    if (message.error().text.empty()) std::abort();
    return 0;
  }
  const auto written = model::to_cbor(*message);
  if (written.size() > model::kMaxMessageBytes) return 0;
  const auto again = model::from_cbor(written);
  if (!again || model::to_cbor(*again) != written) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::cbor_fuzz
