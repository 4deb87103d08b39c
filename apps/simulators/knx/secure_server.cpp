#include <fmt/format.h>

#include <algorithm>

#include "apps/simulators/knx/server.h"
#include "networks/knx/wire/status.h"

// The part of the server that concerns KNX IP Secure.

namespace rubicon::knx_simulator {

using namespace networks::knx::wire;

Result<void> check_users(const ServerOptions& options) {
  if (!options.secure) return {};
  const auto text = [](std::size_t address) {
    return to_string(IndividualAddress(static_cast<std::uint16_t>(address)));
  };
  for (const auto& user : options.secure->users) {
    if (user.address == 0 || options.is_tunnel(user.address)) continue;
    return fail(ErrorCode::kInvalid,
                fmt::format("user {} has the tunnel {}, expected one from {} to {}", user.number, text(user.address),
                            text(options.first_address), text(options.first_address + options.tunnels - 1)));
  }
  return {};
}

/// True if the frame was one of the secure services.
bool Server::takes_secure(const Peer& from, ByteView bytes) {
  const auto frame = read_frame(bytes);
  if (!sessions_ || !frame) return false;
  if (frame->service == ServiceCode::kSessionRequest) {
    base::ByteReader reader(frame->body);
    const auto control = read_hpai(reader);
    if (!control) return true;
    const auto to = peer_of(from, *control);
    const auto connection = from.tcp.lock();
    sessions_->request(
        *frame,
        [this, to](ByteView reply) {
          transmit_wire(to, {reply.begin(), reply.end()}, false);
        },
        connection.get());
    return true;
  }
  if (frame->service != ServiceCode::kSecureWrapper) return false;
  const auto opened = sessions_->unwrap(*frame);
  if (!opened) return true;
  auto peer = from;
  peer.session = opened->session;
  received_plain(peer, opened->frame);
  return true;
}

/// Where sessions are required, only discovery is plain (knx.md, section 10.2).
bool Server::refuses_plain(const Peer& from, ByteView bytes) {
  const auto frame = read_frame(bytes);
  if (!sessions_ || !sessions_->options().required || !frame) return false;
  switch (frame->service) {
    case ServiceCode::kSearchRequest:
    case ServiceCode::kSearchRequestExtended:
    case ServiceCode::kDescriptionRequest: return false;
    case ServiceCode::kConnectRequest: refuse_connect(from, bytes, status::kConnectionType); break;
    default: break;
  }
  ++counters.plain_frames;
  return true;
}

/// A tunnel that only another user gets.
bool Server::is_reserved(std::uint16_t address, const SecureUser* user) const {
  if (!sessions_) return false;
  const auto& users = sessions_->options().users;
  return std::any_of(users.begin(), users.end(),
                     [=](const auto& one) { return one.address == address && &one != user; });
}

void Server::send_in_clear(const Bytes& frame) {
  for (const auto& [id, channel] : channels_) transmit_wire(channel.data, frame, true);
}

void Server::session_ended(std::uint16_t session) {
  std::erase_if(channels_, [&](const auto& entry) { return entry.second.control.session == session; });
}

}  // namespace rubicon::knx_simulator
