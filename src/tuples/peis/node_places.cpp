#include <algorithm>

#include "tuples/peis/node_impl.h"

namespace rubicon::tuples::peis {

/// A name shows nothing: any host may have it. A connection from an address of this host does.
bool Node::Impl::is_here(OwnerId host) const {
  return std::any_of(links.begin(), links.end(), [&](const auto& item) {
    const auto& address = item.second.connection->remote().address;
    const auto is_own = [&](const auto& interface) { return interface.address == address; };
    const auto& own = options.interfaces;
    return item.second.peer == host && item.second.is_route() &&
           (address.starts_with("127.") || std::any_of(own.begin(), own.end(), is_own));
  });
}

/// Whether a kernel says that it is of this host, and nothing shows it yet because its packages come by way of others.
bool Node::Impl::has_no_place(OwnerId kernel) const {
  const auto* host = hosts.find(kernel);
  const auto* route = routes.find(kernel);
  const bool says_here = host && !host->hello && host->host_name == options.host_name;
  if (!says_here || is_here(kernel) || (route && route->direct)) return false;
  const auto since = placeless.find(kernel);
  return since == placeless.end() || scheduler.now() < since->second + kPlaceTime;
}

/// A request that must not be judged before the place of its sender is known: rights depend on it. It is not
/// acknowledged, so that the kernel sends it again if it is lost here.
void Node::Impl::hold(const Package& package) {
  const auto from = package.header.source;
  const bool is_new = !placeless.contains(from);
  if (is_new) dialer.prefer_direct(from);
  if (is_new && placeless.size() >= kMaxPlaceless) return void(++counters.held_requests);
  if (placeless.emplace(from, scheduler.now()).second) {
    place_due.advance_to(scheduler.now() + kPlaceTime);
  }
  const bool is_again = std::any_of(held.begin(), held.end(), [&](const Held& one) {
    return one.header.source == from && one.header.ack_id == package.header.ack_id;
  });
  if (is_again) return;
  std::size_t bytes = package.body.size(), of_one = 0;
  for (const auto& one : held) {
    bytes += one.body.size();
    if (one.header.source == from) ++of_one;
  }
  if (held.size() >= kMaxHeld || of_one >= kMaxHeldOfOne || bytes > kMaxHeldBytes)
    return void(++counters.held_requests);
  held.push_back({package.header, Bytes(package.body.begin(), package.body.end())});
}

bool Node::Impl::is_held(OwnerId kernel) const {
  return std::any_of(held.begin(), held.end(), [&](const Held& one) { return one.header.source == kernel; });
}

/// The requests of those whose place is known by now, or was not shown in time.
void Node::Impl::release() {
  const auto now = scheduler.now();
  std::vector<Held> ready;
  std::erase_if(held, [&](Held& one) {
    if (has_no_place(one.header.source)) return false;
    ready.push_back(std::move(one));
    return true;
  });
  for (const auto& one : ready) take_message({one.header, one.body});
  std::erase_if(placeless, [&](const auto& one) { return now - one.second > kForgetPlace || is_here(one.first); });
  auto next = SteadyTime::max();
  for (const auto& [kernel, since] : placeless)
    next = std::min(next, now < since + kPlaceTime ? since + kPlaceTime : since + kForgetPlace);
  place_due.set_at(next);
}

}  // namespace rubicon::tuples::peis
