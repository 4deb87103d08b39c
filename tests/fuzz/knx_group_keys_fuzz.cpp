#include <cstddef>
#include <cstdint>
#include <string_view>

#include "fuzz_target.h"
#include "networks/knx/secure/group_keys.h"

namespace rubicon::fuzz::knx_group_keys_fuzz {

/// A file of group keys. What is taken has a key for each group, and each group some sender.
FUZZ_TARGET(knx_group_keys) {
  if (size > 65536) return 0;
  const auto keys = rubicon::networks::knx::secure::parse_group_keys({reinterpret_cast<const char*>(data), size});
  if (!keys) return 0;
  if (keys->groups.empty()) __builtin_trap();
  for (const auto& [group, entry] : keys->groups) {
    if (!entry.key || entry.any_sender != entry.senders.empty()) __builtin_trap();
  }
  return 0;
}

}  // namespace rubicon::fuzz::knx_group_keys_fuzz
