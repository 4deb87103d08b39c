#include "island/network_memory.h"

#include <fmt/format.h>

namespace rubicon::island {

Result<void> NetworkMemory::remember(const std::string& network, std::string_view name, ByteView value,
                                     network::Keep keep) {
  if (!store_)
    return fail(ErrorCode::kUnsupported, "nothing can be remembered without a state file (state: {file: ...})");
  if (const auto fits = network::check_memory(name, value); !fits)
    return fail(fits.error().code, fmt::format("network {}: {}", network, fits.error().text));
  return store_->remember(network, name, value, network::kMostMemories, keep == network::Keep::kNow);
}

Result<std::optional<Bytes>> NetworkMemory::remembered(const std::string& network, std::string_view name) {
  if (!store_)
    return fail(ErrorCode::kUnsupported, "nothing can be remembered without a state file (state: {file: ...})");
  return store_->remembered(network, name);
}

}  // namespace rubicon::island
