#include "networks/knx/knx_line.h"

#include <fmt/format.h>

#include <random>
#include <tuple>
#include <utility>

namespace rubicon::networks::knx {

namespace {

auto parts(const line::TelegramQueue::Limits& limits) {
  return std::tie(limits.rate, limits.burst, limits.queue);
}

auto parts(const line::TunnelOptions& o) {
  return std::tuple_cat(std::tie(o.host, o.port, o.local_port, o.via, o.nat, o.wanted, o.max_apdu), parts(o.limits));
}

auto parts(const line::RoutingOptions& o) {
  return std::tuple_cat(std::tie(o.group, o.interface_address, o.ttl, o.address), parts(o.limits));
}

}  // namespace

bool same_line(const LineOptions& one, const LineOptions& other) {
  if (one.via != other.via) return false;
  return one.via == Via::kRouting ? parts(one.routing) == parts(other.routing)
                                  : parts(one.tunnel) == parts(other.tunnel) && one.hosts == other.hosts &&
                                        one.gateway_check == other.gateway_check;
}

std::unique_ptr<line::Line> make_line(const LineOptions& options, Scheduler& scheduler,
                                      transport::Transports& transports, line::LineCallbacks calls) {
  if (options.via == Via::kRouting) {
    auto routing = options.routing;
    routing.seed = std::random_device()();
    return std::make_unique<line::RoutingLine>(scheduler, transports, routing, std::move(calls));
  }
  if (options.hosts.size() < 2)
    return std::make_unique<line::TunnelLine>(options.tunnel, scheduler, transports, std::move(calls));
  auto gateways = options.gateways;
  if (gateways.empty()) {
    for (const auto& host : options.hosts) gateways.push_back({host, options.tunnel.secure, options.tunnel.wanted});
  }
  return std::make_unique<line::GatewayLine>(
      line::GatewayOptions{options.tunnel, std::move(gateways), options.gateway_check}, scheduler, transports,
      std::move(calls));
}

std::vector<wire::IndividualAddress> TunnelRound::unusable() const {
  auto all = taken_;
  all.insert(all.end(), users_refused_.begin(), users_refused_.end());
  return all;
}

bool TunnelRound::end(bool last_was_refused, const Error& why) {
  const bool others_wait = last_was_refused && !taken_.empty();
  text_ = why.text;
  finding_ = why.finding;
  for (const auto tunnel : users_refused_)
    text_ += fmt::format("{}the interface refuses the user of {}", text_.empty() ? "" : "; ", to_string(tunnel));
  if (last_was_refused && taken_.empty()) users_refused_.clear();
  taken_.clear();
  return others_wait;
}

void TunnelRound::up() {
  taken_.clear();
  text_.clear();
}

}  // namespace rubicon::networks::knx
