#include "tuples/peis/announcer.h"

#include <fmt/format.h>

#include <utility>

namespace rubicon::tuples::peis {

namespace {

using namespace std::chrono_literals;

constexpr Duration kPeriod = 1s;
constexpr Duration kSilence = 3s;  ///< without the other announcer before this one takes over
/// Kernels print a warning for each announcement of a higher id: those leave it to others on their host.
constexpr std::uint32_t kMostWelcomeId = 65535;
constexpr Duration kLongSilence = 5s;
constexpr Duration kSoon = 200ms;  ///< between announcements out of turn
/// Components that start together do not all announce: the lowest ids are first.
constexpr Duration kSpread = 50ms;

}  // namespace

Announcer::Announcer(Scheduler& scheduler, transport::Transports& transports, Where where, Counters& counters,
                     base::LimitedLog& log, Calls calls)
    : scheduler_(scheduler),
      transports_(transports),
      network_(std::move(where.network)),
      counters_(counters),
      log_(log),
      calls_(std::move(calls)),
      soon_(scheduler, kSoon, [this] { send(); }) {
  for (auto& interface : where.interfaces) sockets_.push_back({std::move(interface), nullptr, {}});
  for (auto& socket : sockets_) open(socket);
  const auto spread = kSpread * (number(calls_.record().id) % 64) / 64;
  timer_ = scheduler_.after(spread, [this] { tick(); });
}

void Announcer::open(Socket& socket) {
  transport::UdpOptions options;
  options.local = {std::string(kMulticastGroup), kMulticastPort};
  options.reuse_address = true;
  options.multicast = {{std::string(kMulticastGroup)}, socket.interface.address, kMulticastHops, true};
  transport::UdpCalls calls;
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
    if (version) calls_.trouble(TroubleKind::kForeignVersion, {}, {}, announcement.error().text);
    return;
  }
  if (announcement->network != network_) {
    ++counters_.foreign_networks;
    const auto& host = announcement->host;
    return calls_.trouble(TroubleKind::kForeignNetwork, host.id, host.full_name, announcement->network);
  }
  const auto own = calls_.record();
  if (announcement->host == own) return;
  if (announcement->host.host_name == own.host_name && announcement->host.id < own.id)
    silent_until_ = scheduler_.now() + (number(own.id) > kMostWelcomeId ? kLongSilence : kSilence);
  calls_.heard(announcement->host);
}

void Announcer::tick() {
  timer_ = scheduler_.after(kPeriod, [this] { tick(); });
  send();
}

void Announcer::send() {
  if (!is_active()) return;
  const auto datagram = write(Announcement{network_, calls_.record()});
  for (auto& socket : sockets_) {
    if (!socket.socket) continue;
    const auto sent = socket.socket->send({std::string(kMulticastGroup), kMulticastPort}, datagram);
    if (!sent) log_.debug("multicast " + socket.interface.name, sent.error().text);
  }
}

}  // namespace rubicon::tuples::peis
