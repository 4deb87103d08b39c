#include <cstdlib>
#include <string_view>

#include "fuzz_target.h"
#include "proxy/admission/command_transfer.h"

namespace rubicon::fuzz::roaming_fuzz {

/// Input: what another island says in a claim, or hands over as a waiting command. What was read must be written so
/// that it reads as the same again.
FUZZ_TARGET(roaming) {
  using namespace rubicon;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (const auto claim = proxy::admission::parse_claim(OwnerId(1), text)) {
    const auto written = proxy::admission::claim_text(*claim);
    const auto again = proxy::admission::parse_claim(OwnerId(1), written);
    if (written.size() <= 4096 && (!again || !(*again == *claim))) std::abort();
  } else if (claim.error().text.empty()) {
    std::abort();
  }
  if (const auto command = proxy::admission::parse_waiting_command(text)) {
    const auto written = proxy::admission::waiting_command_text(*command);
    const auto again = proxy::admission::parse_waiting_command(written);
    if (written.size() <= 32 * 1024 && (!again || !(*again == *command))) std::abort();
  } else if (command.error().text.empty()) {
    std::abort();
  }
  return 0;
}

}  // namespace rubicon::fuzz::roaming_fuzz
