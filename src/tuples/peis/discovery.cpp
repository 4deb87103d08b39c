#include "tuples/peis/discovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "transport/host_names.h"

namespace rubicon::tuples::peis {

namespace {

using namespace std::chrono_literals;

constexpr Duration kPeriod = 1s;
constexpr Duration kSilence = 3s;  ///< without the other announcer before this one takes over
/// Kernels print a warning for each announcement of a higher id: those leave it to others on their host.
constexpr std::uint32_t kMaxWelcomeId = 65535;
constexpr Duration kLongSilence = 5s;
constexpr Duration kSoon = 200ms;  ///< between announcements out of turn
/// Components that start together do not all announce: the lowest ids are first.
constexpr Duration kSpread = 50ms;

}  // namespace

Announcer::Announcer(Scheduler& scheduler, transport::Transports& transports, Where where, NodeCounters& counters,
                     base::LimitedLog& log, Callbacks calls)
    : scheduler_(scheduler),
      transports_(transports),
      network_(std::move(where.network)),
      counters_(counters),
      log_(log),
      callbacks_(std::move(calls)),
      soon_(scheduler, kSoon, [this] { send(); }) {
  for (auto& interface : where.interfaces) sockets_.push_back({std::move(interface), nullptr, {}});
  for (auto& socket : sockets_) open(socket);
  const auto spread = kSpread * (number(callbacks_.record().id) % 64) / 64;
  timer_ = scheduler_.after(spread, [this] { tick(); });
}

void Announcer::open(Socket& socket) {
  transport::UdpOptions options;
  options.local = {std::string(kMulticastGroup), kMulticastPort};
  options.reuse_address = true;
  options.multicast = {{std::string(kMulticastGroup)}, socket.interface.address, kMulticastHops, true};
  transport::UdpCallbacks calls;
  calls.received = [this](const transport::Endpoint&, ByteView bytes) { received(bytes); };
  calls.undelivered = [](const Error&) {};
  calls.failed = [this, &socket](const Error& error) {
    log_.warning("multicast " + socket.interface.name, error.text);
    open_later(socket);
  };
  auto opened = transports_.open_udp(options, std::move(calls));
  if (opened) return void(socket.socket = std::move(*opened));
  log_.warning("multicast " + socket.interface.name,
               fmt::format("cannot announce on interface {}: {}", socket.interface.name, opened.error().text));
  open_later(socket);
}

void Announcer::open_later(Socket& socket) {
  socket.socket.reset();
  socket.again = scheduler_.after(kOpenAgain, [this, &socket] { open(socket); });
}

void Announcer::received(ByteView datagram) {
  const auto announcement = read_announcement(datagram);
  if (!announcement) {
    const bool version = announcement.error().code == ErrorCode::kUnsupported;
    ++(version ? counters_.foreign_versions : counters_.bad_announcements);
    log_.debug("announcement", announcement.error().text);
    if (version) callbacks_.trouble(TroubleKind::kForeignVersion, {}, {}, announcement.error().text);
    return;
  }
  if (announcement->network != network_) {
    ++counters_.foreign_networks;
    const auto& host = announcement->host;
    return callbacks_.trouble(TroubleKind::kForeignNetwork, host.id, host.full_name, announcement->network);
  }
  const auto own = callbacks_.record();
  if (announcement->host == own) return;
  if (announcement->host.host_name == own.host_name && announcement->host.id < own.id)
    silent_until_ = scheduler_.now() + (number(own.id) > kMaxWelcomeId ? kLongSilence : kSilence);
  callbacks_.heard(announcement->host);
}

void Announcer::tick() {
  timer_ = scheduler_.after(kPeriod, [this] { tick(); });
  send();
}

void Announcer::send() {
  if (!is_active()) return;
  const auto datagram = write(Announcement{network_, callbacks_.record()});
  for (auto& socket : sockets_) {
    if (!socket.socket) continue;
    const auto sent = socket.socket->send({std::string(kMulticastGroup), kMulticastPort}, datagram);
    if (!sent) log_.debug("multicast " + socket.interface.name, sent.error().text);
  }
}

namespace {

constexpr int kMaxFailures = 8;  ///< of a host that only announcements name; then it must be announced again

/// The pause after a number of failures: 1.5 s from the second failure on, then longer ones.
Duration pause_after(int failures) {
  return std::min<Duration>(1500ms * (1 << std::min(failures - 2, 4)), Dialer::kMaxPauseTime);
}

}  // namespace

Dialer::Dialer(Scheduler& scheduler, transport::Transports& transports, Own own, Callbacks calls)
    : scheduler_(scheduler),
      transports_(transports),
      own_(std::move(own)),
      callbacks_(std::move(calls)),
      random_(own_.seed),
      next_(scheduler, [this] { sweep(); }) {
  for (auto& where : own_.configured) configured_.push_back({where, {}, {}, false, nullptr});
  for (auto& configured : configured_) schedule(configured.next, {});
}

Duration Dialer::jitter(Duration from, Duration to) {
  return from + (to - from) * static_cast<int>(random_() % 1024) / 1024;
}

void Dialer::schedule(Try& next, Duration delay) {
  const auto due = scheduler_.now() + delay;
  if (next.dialing || next.due <= due) return;
  next.due = due;
  next_.advance_to(due);
}

void Dialer::meet(OwnerId host, bool is_lower_cluster, bool first) {
  auto* found = obtain(host, false);
  if (!found) return;
  auto& next = *found;
  if (next.failures >= kMaxFailures) next.failures = 0;
  if (!is_lower_cluster) return schedule(next, jitter(2s, 3s));
  schedule(next, first ? jitter(0ms, 20ms) : jitter(300ms, 1s));
}

void Dialer::prefer_direct(OwnerId host) {
  const auto now = scheduler_.now();
  auto* found = obtain(host, false);
  if (!found) return;
  auto& next = *found;
  if (next.dialing || (next.last_direct != SteadyTime{} && now - next.last_direct < kDirectPause)) return;
  next.last_direct = now;
  next.direct = true;
  schedule(next, host < own_.id ? jitter(0ms, 5ms) : jitter(20ms, 50ms));  // the other one may try too
}

void Dialer::again(OwnerId host, bool first) {
  auto* next = obtain(host, true);
  if (!next) return;
  next->direct = true;
  schedule(*next, std::max(pause_after_break(*next), first ? Duration{} : jitter(100ms, 200ms)));
}

/// Null: too many hosts.
Dialer::Try* Dialer::obtain(OwnerId host, bool broke) {
  const auto limit = kMaxHostTries + (broke ? kReserved : 0);
  if (!tries_.contains(host) && tries_.size() >= limit) return callbacks_.refused(host), nullptr;
  auto& next = tries_[host];
  next.broke = next.broke || broke;
  renew(host, next);
  return &next;
}

/// Another start of a host has other addresses: the pauses of the former ones do not count.
void Dialer::renew(OwnerId host, Try& next) {
  const auto* record = callbacks_.record(host);
  if (!record || std::exchange(next.magic, record->magic) == record->magic) return;
  next.failures = 0;
  next.address = 0;
  next.last_direct = {};
}

bool Dialer::is_young(const Try& next, SteadyTime now) {
  return next.connected != SteadyTime{} && now - next.connected < kYoung;
}

/// None after the first break: the other end may have started again.
Duration Dialer::pause_after_break(Try& next) {
  next.breaks = is_young(next, scheduler_.now()) ? next.breaks + 1 : 0;
  return next.breaks <= 1 ? Duration{} : pause_after(next.breaks);
}

void Dialer::connected(const Target& target, OwnerId host) {
  release(target);
  if (target.configured >= 0) {
    auto& configured = configured_.at(static_cast<std::size_t>(target.configured));
    configured.host = host;
    configured.linked = true;
    configured.next.failures = 0;
    configured.next.connected = scheduler_.now();
  }
  auto* next = obtain(host, true);
  if (!next) return;
  next->failures = 0;
  next->direct = false;
  next->connected = scheduler_.now();
  next->due = SteadyTime::max();
}

/// Removes and returns the attempt for the target; null: there is none.
Dialer::Try* Dialer::release(const Target& target) {
  Try* next = nullptr;
  if (target.configured >= 0) {
    next = &configured_.at(static_cast<std::size_t>(target.configured)).next;
  } else if (const auto found = tries_.find(target.host); found != tries_.end()) {
    next = &found->second;
  }
  if (next && std::exchange(next->dialing, false) && target.configured < 0) --dialing_;
  return next;
}

void Dialer::ended(const Target& target, bool was_connected) {
  auto* next = release(target);
  if (target.configured >= 0) configured_.at(static_cast<std::size_t>(target.configured)).linked = false;
  if (!next || (was_connected && target.configured < 0)) return;  // again() follows
  if (was_connected) return schedule(*next, pause_after_break(*next));
  ++next->failures, ++next->address;
  failed(*next);
}

/// The next try: soon, after 1.5 s, then with longer pauses.
void Dialer::failed(Try& next) {
  schedule(next, next.failures <= 1 ? Duration(100ms) : pause_after(next.failures));
}

void Dialer::forget(OwnerId host) {
  const auto found = tries_.find(host);
  if (found == tries_.end()) return;
  if (found->second.dialing) --dialing_;
  tries_.erase(found);
}

void Dialer::sweep() {
  const auto now = scheduler_.now();
  std::vector<OwnerId> due;
  for (const auto& [host, next] : tries_) {
    if (next.due <= now) due.push_back(host);
  }
  for (const auto host : due) try_host(host, tries_[host]);
  for (std::size_t i = 0; i < configured_.size(); ++i) {
    if (configured_[i].next.due <= now) try_configured(i);
  }
  std::erase_if(tries_, [&](const auto& item) {
    const auto& next = item.second;
    return !next.dialing && next.due == SteadyTime::max() && now - next.last_direct > kDirectPause &&
           now - next.connected > kMaxPauseTime + kYoung;
  });
  for (const auto& [host, next] : tries_) next_.advance_to(next.due);
  for (const auto& configured : configured_) next_.advance_to(configured.next.due);
}

void Dialer::try_host(OwnerId host, Try& next) {
  next.due = SteadyTime::max();
  if (callbacks_.is_linked(host) || (callbacks_.is_routable(host) && !next.direct)) return;
  if (next.failures >= kMaxFailures) return;
  const auto address = address_of(host, next.address);
  if (!address) return;
  if (dialing_ >= kMaxTries + (next.broke ? kReservedTries : 0)) return schedule(next, 50ms);
  next.dialing = true;
  ++dialing_;
  if (callbacks_.dial({host, -1}, *address, kForcedByCluster)) return;
  next.dialing = false;
  --dialing_;
  ++next.failures;
  failed(next);
}

void Dialer::try_configured(std::size_t index) {
  auto& configured = configured_[index];
  configured.next.due = SteadyTime::max();
  if (configured.linked || configured.next.dialing) return;
  if (configured.host != OwnerId{} && callbacks_.is_linked(configured.host))
    return schedule(configured.next, kMaxPauseTime);
  configured.next.dialing = true;
  const Target target{{}, static_cast<int>(index)};
  configured.lookup = transports_.look_up(configured.where.host, [this, target](const auto& addresses) {
    if (addresses) return dial_configured(target, *addresses);
    callbacks_.unresolved(target, addresses.error());
    ended(target, false);
  });
}

/// Its own addresses in turn, and after each of them one that others announce for it.
std::optional<transport::Endpoint> Dialer::address_of(OwnerId host, std::size_t which) const {
  auto own = addresses_of(callbacks_.record(host));
  auto claimed = addresses_of(callbacks_.claim(host));
  if (own.empty()) own.swap(claimed);
  if (own.empty()) return std::nullopt;
  if (claimed.empty()) return own[which % own.size()];
  return which % 2 == 0 ? own[which / 2 % own.size()] : claimed[which / 2 % claimed.size()];
}

void Dialer::dial_configured(const Target& target, std::vector<std::string> addresses) {
  const auto& found = configured_.at(static_cast<std::size_t>(target.configured));
  if (own_.loopback_only)
    std::erase_if(addresses, [](const auto& address) { return !transport::is_loopback_address(address); });
  if (addresses.empty()) {
    callbacks_.unresolved(target,
                          {ErrorCode::kUnreachable, "lo reaches no other host, expected another interface too"});
    return ended(target, false);
  }
  const auto& address = addresses.at(found.next.address % addresses.size());
  if (!callbacks_.dial(target, {address, found.where.port}, kForcedByCluster | kForceBroadcasts)) ended(target, false);
}

/// Loopback addresses lead to a host only from itself: one with the same name (section 6.2, 15).
std::vector<transport::Endpoint> Dialer::addresses_of(const HostRecord* record) const {
  std::vector<transport::Endpoint> addresses;
  if (!record) return addresses;
  const bool same_host = record->host_name == own_.host_name;
  for (const auto& address : record->addresses) {
    if (address.type != AddressType::kTcp4 || address.port == 0 || address.port > 0xffff) continue;
    const bool loopback = address.loopback || address.ip[0] == 127;
    if (own_.loopback_only && address.ip[0] != 127) continue;
    if (loopback && !same_host) continue;
    const auto& ip = address.ip;
    const transport::Endpoint endpoint{fmt::format("{}.{}.{}.{}", ip[0], ip[1], ip[2], ip[3]),
                                       static_cast<std::uint16_t>(address.port)};
    if (loopback) {
      addresses.insert(addresses.begin(), endpoint);
    } else {
      addresses.push_back(endpoint);
    }
  }
  return addresses;
}

}  // namespace rubicon::tuples::peis
