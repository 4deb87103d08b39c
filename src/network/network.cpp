#include "network/network.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace rubicon::network {

Result<void> check_memory(std::string_view name, ByteView value) {
  const auto fits = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '-'; };
  if (name.empty() || name.size() > kMaxMemoryName || !std::all_of(name.begin(), name.end(), fits)) {
    return fail(ErrorCode::kOutOfRange, fmt::format("a value is to be remembered under a name of {} bytes, expected 1 "
                                                    "to {} of a to z, 0 to 9, dot and hyphen",
                                                    name.size(), kMaxMemoryName));
  }
  if (value.size() <= kMaxMemoryValue) return {};
  return fail(ErrorCode::kOutOfRange,
              fmt::format("{} has {} bytes, at most {} are remembered", name, value.size(), kMaxMemoryValue));
}

void NetworkHost::deliver(std::string device, model::Body body) {
  deliver(Message{.source = {{}, {}, std::move(device)}, .destination = {}, .body = std::move(body)});
}

Result<TupleWatch> NetworkHost::watch_tuple(std::string_view, std::function<void(std::string_view value)>) {
  return fail(ErrorCode::kUnsupported, "this host has no tuples");
}

Result<void> NetworkHost::remember(std::string_view, ByteView, Keep) {
  return fail(ErrorCode::kUnsupported, "nothing can be remembered without a state file (state: {file: ...})");
}

Result<std::optional<Bytes>> NetworkHost::remembered(std::string_view) {
  return fail(ErrorCode::kUnsupported, "nothing can be remembered without a state file (state: {file: ...})");
}

Result<void> Network::reopen() {
  return fail(ErrorCode::kUnsupported, "no attempt is planned: the line waits for its peer");
}

Result<void> Network::change(const NetworkConfig&) {
  return fail(ErrorCode::kUnsupported, "this type of network cannot change its options while it runs");
}

bool Network::close(std::function<void()>) {  // NOLINT(performance-unnecessary-value-param): as others keep it
  return false;
}

std::optional<std::vector<ListedDevice>> Network::listed() const {
  return std::nullopt;
}

std::vector<Missing> Network::missing() const {
  return {};
}

std::vector<Control> Network::controls() const {
  return {};
}

Result<void> Network::control(std::string_view name, std::string_view) {
  return fail(ErrorCode::kNotFound, fmt::format("this network has no {}", name));
}

Error wrong_options(const NetworkConfig& config) {
  return {ErrorCode::kInvalid, fmt::format("network {}: wrong options", config.id)};
}

}  // namespace rubicon::network
