#include "island/network_memory.h"

#include <fmt/format.h>

#include <algorithm>

namespace rubicon::island {

namespace {

bool is_name(std::string_view name) {
  const auto fits = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '-'; };
  return !name.empty() && name.size() <= network::kMaxMemoryName && std::all_of(name.begin(), name.end(), fits);
}

}  // namespace

Result<void> NetworkMemory::remember(const std::string& network, std::string_view name, ByteView value) {
  if (!store_)
    return fail(ErrorCode::kUnsupported, "nothing can be remembered without a state file (state: {file: ...})");
  if (!is_name(name)) {
    return fail(ErrorCode::kOutOfRange, fmt::format("network {}: a value is to be remembered under a name of {} bytes, "
                                                    "expected 1 to {} of a to z, 0 to 9, dot and hyphen",
                                                    network, name.size(), network::kMaxMemoryName));
  }
  if (value.size() > network::kMaxMemoryValue) {
    return fail(ErrorCode::kOutOfRange, fmt::format("network {}: {} has {} bytes, at most {} are remembered", network,
                                                    name, value.size(), network::kMaxMemoryValue));
  }
  return store_->remember(network, name, value, network::kMostMemories);
}

Result<std::optional<Bytes>> NetworkMemory::remembered(const std::string& network, std::string_view name) {
  return store_ ? store_->remembered(network, name) : Result<std::optional<Bytes>>(std::optional<Bytes>());
}

}  // namespace rubicon::island
