#include <cstdlib>

#include "fuzz_target.h"
#include "networks/knx/dpt/convert_line.h"
#include "networks/knx/dpt/dpt.h"

namespace rubicon::fuzz::knx_dpt_fuzz {

/// Input: the place of a type (two octets), the form of the payload (one octet), then the payload, which is also read
/// as text somebody typed.
FUZZ_TARGET(knx_dpt) {
  using namespace rubicon;
  using namespace rubicon::networks::knx::dpt;
  using namespace rubicon::networks::knx::wire;
  if (size < 3) return 0;
  const auto types = all_dpts();
  const auto* type = &types[(data[0] * 256U + data[1]) % types.size()];
  if ((data[2] & 2) != 0) type = find_dpt({type->id.main, DptId::kMainOnly});
  const ByteView bytes(data + 3, size - 3);
  const auto text = base::as_text(bytes);
  if (const auto value = decode(*type, PayloadView{bytes, (data[2] & 1) != 0})) {
    // What was understood can be sent, and is understood again; but ISO 8859-1 in a text of ASCII is read only.
    const auto sent = encode(*type, *value);
    const bool reads_more = type->maximum == 127 && std::holds_alternative<std::string>(*value);
    if (!sent && reads_more) return 0;
    if (!sent) std::abort();
    const auto again = decode(*type, *sent);
    if (!again || *again != *value) std::abort();
    const auto there = to_catalogue(*type, Kind::kSensor, *value);
    if (there && !from_catalogue(*type, Kind::kSensor, *there)) std::abort();
    if (label(*type, *value).size() > 65536) std::abort();
  }
  if (const auto sent = encode_text(*type, text); sent && !decode(*type, *sent)) std::abort();
  static_cast<void>(parse_dpt(text));
  static_cast<void>(encode_line(text));
  if (decode_line(text).find('\n') != std::string::npos && text.find('\n') == text.npos) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::knx_dpt_fuzz
