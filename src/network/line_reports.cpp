#include "network/line_reports.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

namespace rubicon::network {

void StateReporter::line_changed() {
  pending_.cancel();
  if (auto state = state_()) host_.deliver({}, std::move(*state));
}

void StateReporter::counters_changed() {
  if (pending_.pending()) return;
  pending_ = host_.scheduler().after(period_, [this] { line_changed(); });
}

namespace {

Duration lease_of(const nlohmann::json& request) {
  const auto seconds = request.find("seconds");
  if (seconds == request.end() || !seconds->is_number_integer()) return Monitors::kUsual;
  constexpr auto kMaxSecondCount = std::chrono::duration_cast<std::chrono::seconds>(Monitors::kMaxTime).count();
  return std::chrono::seconds(std::clamp<std::int64_t>(seconds->get<std::int64_t>(), 0, kMaxSecondCount));
}

}  // namespace

Result<void> Monitors::ask(const Address& program, const std::string& id, const nlohmann::json& request) {
  all_.remove_if([&](const Monitor& one) { return one.program == program && one.id == id; });
  const auto lease = lease_of(request);
  if (lease == Duration::zero()) return {};
  if (all_.size() >= kMaxCount) return fail(ErrorCode::kBusy, "too many monitors are open");
  auto& added = all_.emplace_back(Monitor{program, id, {}});
  added.lease = host_.scheduler().after(
      lease, [this, &added] { all_.remove_if([&](const Monitor& one) { return &one == &added; }); });
  return {};
}

void Monitors::send(std::string_view tag, std::string_view text) {
  for (const auto& monitor : all_) send_text(host_, monitor.program, tag, text);
}

void send_text(NetworkHost& host, const Address& to, std::string_view tag, std::string_view text) {
  model::Message message;
  message.destination = to;
  const auto bytes = base::as_bytes(text);
  message.body = model::Opaque{std::string(tag), Bytes(bytes.begin(), bytes.end())};
  host.deliver(std::move(message));
}

}  // namespace rubicon::network
