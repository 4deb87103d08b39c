#include "network/network.h"

#include <fmt/format.h>

#include <utility>

namespace rubicon::network {

void NetworkHost::deliver(std::string device, model::Body body) {
  Message message;
  message.source.device = std::move(device);
  message.body = std::move(body);
  deliver(std::move(message));
}

Result<TupleWatch> NetworkHost::watch_tuple(std::string_view, std::function<void(std::string_view value)>) {
  return fail(ErrorCode::kUnsupported, "this host has no tuples");
}

Result<void> NetworkHost::remember(std::string_view, ByteView) {
  return fail(ErrorCode::kUnsupported, "nothing can be remembered without a state file (state: {file: ...})");
}

Result<std::optional<Bytes>> NetworkHost::remembered(std::string_view) {
  return std::optional<Bytes>();
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
