#include <cstdlib>

#include "fuzz_target.h"
#include "networks/salad/salad_codec.h"

namespace rubicon::fuzz::salad_datagram_fuzz {

/// Input: the low byte of the buffer's size, then a datagram.
FUZZ_TARGET(salad_datagram) {
  using namespace rubicon;
  using namespace rubicon::networks::salad;
  if (size < 1) return 0;
  const ByteView bytes(data + 1, size - 1);
  const auto read = read_datagram(bytes, data[0] + std::size_t{16});
  std::uint64_t faults = 0;
  for (const auto& [fault, times] : read.faults) {
    if (to_string(fault).empty() || times == 0) std::abort();
    faults += times;
  }
  if (read.items.size() + faults > bytes.size() + 1) std::abort();
  if (read.items.empty() && faults == 0) std::abort();
  // What was understood is understood again.
  for (const auto& item : read.items) {
    if (item.id == 0) std::abort();
    const auto again = read_datagram(base::as_bytes(write_datagram({item})), 1 << 20);
    if (again.items.size() != 1 || again.items[0].id != item.id) std::abort();
    if (model::to_text(again.items[0].value) != model::to_text(item.value)) std::abort();
  }
  if (const auto request = read_request(bytes); request && request->kind == Request::Kind::kActuate) {
    const auto again = read_request(base::as_bytes(actuate(request->actuator, request->value)));
    if (!again || again->actuator != request->actuator || again->value != request->value) std::abort();
  }
  return 0;
}

}  // namespace rubicon::fuzz::salad_datagram_fuzz
