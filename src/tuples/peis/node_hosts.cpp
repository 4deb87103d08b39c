#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <utility>

#include "tuples/peis/node_impl.h"

namespace rubicon::tuples::peis {

namespace {

/// Nullopt: no IPv4 address.
std::optional<std::array<std::uint8_t, 4>> parse_ip(const std::string& text) {
  std::array<unsigned, 4> parts{};
  char rest = 0;
  if (std::sscanf(text.c_str(), "%3u.%3u.%3u.%3u%c", &parts[0], &parts[1], &parts[2], &parts[3], &rest) != 4)
    return std::nullopt;
  std::array<std::uint8_t, 4> ip{};
  for (std::size_t i = 0; i < ip.size(); ++i) {
    if (parts[i] > 255) return std::nullopt;
    ip[i] = static_cast<std::uint8_t>(parts[i]);
  }
  return ip;
}

}  // namespace

HostRecord Node::Impl::own_record() const {
  HostRecord record;
  record.id = options.id;
  record.magic = options.magic;
  record.host_name = options.host_name;
  record.full_name = options.full_name;
  record.cluster = routes.cluster();
  for (const auto& interface : options.interfaces) {
    const auto ip = parse_ip(interface.address);
    if (!ip) continue;
    record.addresses.push_back(
        {interface.name.substr(0, 8), interface.is_loopback, AddressType::kTcp4, *ip, local.port});
  }
  return record;
}

void Node::Impl::announced(const HostRecord& record) {
  if (record.id == options.id) {
    if (record.magic != options.magic) id_claimed(record);
    return;
  }
  const auto id = number(record.id);
  if (id == 0 || id > kMaxId) return void(++counters.bad_ids);
  // Only programs that run announce themselves.
  if (hosts.is_over(record.id, record.magic))
    troubles.note(TroubleKind::kSharedId, record.id, record.full_name, "it announces itself after another start");
  is_other_start(record, "an announcement");
  if (!hosts.learn(record, RecordSource::kAnnounced) || routes.find(record.id)) return;
  const auto own = routes.cluster();
  // It cannot hear a component that leaves announcing to a kernel: by way of kernels the route here takes up to 10 s.
  const bool is_ours_to_connect = record.cluster <= own || !announcer->is_active();
  dialer.meet(record.id, is_ours_to_connect, announcer->is_active() || routes.all().empty());
  if (record.cluster != own) announcer->announce();
}

/// Anyone may say so: the other one is asked.
void Node::Impl::id_claimed(const HostRecord& record) {
  ++counters.own_id_seen;
  troubles.note(TroubleKind::kOwnId, record.id, record.full_name, {});
  if (taken_magics.contains(record.magic)) return;
  log.info("own id",
           fmt::format("{} says that it has the id {} of this component: asked", record.full_name, number(record.id)));
  id_check.ask({record.id, record.magic, record.host_name, record.full_name, std::nullopt},
               dialer.addresses_of(&record));
}

void Node::Impl::id_taken(const Identity& other) {
  if (taken_magics.size() >= kMaxTakenMagics || !taken_magics.insert(other.magic).second) return;
  log.unlimited().warning(
      fmt::format("another component uses the id {} of this one: {}", number(other.id), other.full_name));
  troubles.note(TroubleKind::kOwnId, other.id, other.full_name, {});
  calls.id_taken(other);
}

void Node::Impl::happened(HostEvent event, const Identity& host) {
  if (event == HostEvent::kBack) deliveries.send_again(host.id);
  calls.host(event, host);
  // What it sent before its hello, which was lost and sent again, was taken for that of a kernel.
  if (event == HostEvent::kHello) returned(host);
}

/// Hello is the first that it gets.
void Node::Impl::welcome(OwnerId host) {
  deliveries.open(host, hosts.is_ours(host));
  const auto sent = deliveries.send(host, Port::kHello, encode(options.hello), {});
  if (!sent) log.debug("hello", sent.error().text);
  // A kernel on the way lets others know this one only with its next routing, up to 10 s later.
  const auto* route = routes.find(host);
  if (route && !route->direct && !hosts.is_ours(route->via)) dialer.prefer_direct(host);
}

/// This node had deleted the host's subscriptions. One of ours is asked to send them again; a kernel does so when it
/// meets a host that had left.
void Node::Impl::returned(const Identity& host) {
  const auto tell = [&](const DeadHost& dead) {
    const auto sent = deliveries.send(host.id, Port::kDeadHost, write(dead), {});
    if (!sent) log.debug("returned", sent.error().text);
  };
  if (host.hello) return tell({host.id, DeathReason::kReborn});
  const auto* route = routes.find(host.id);
  if (!route || !route->direct) return tell({options.id, DeathReason::kLost});
  send_direct(host.id, Port::kDeadHost, write(DeadHost{options.id, DeathReason::kLost}));
  std::vector<LinkId> all;
  for (const auto& [id, link] : links) {
    if (link.peer == host.id) all.push_back(id);
  }
  for (const auto id : all) close(*link(id));
  dialer.again(host.id, true);
}

void Node::Impl::leave_host(OwnerId host) {
  hosts.left(host);
  dialer.forget(host);
  apply(routes.forget(host, scheduler.now()));
  std::vector<LinkId> all;
  for (const auto& [id, link] : links) {
    if (link.peer == host) all.push_back(id);
  }
  for (const auto id : all) close(*link(id));
}

}  // namespace rubicon::tuples::peis
