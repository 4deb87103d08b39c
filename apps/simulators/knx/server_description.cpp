#include <algorithm>

#include "apps/simulators/knx/server.h"

// What the server says of itself: descriptions, extended searches and tunnelling features.

namespace rubicon::knx_simulator {

using namespace networks::knx::wire;

namespace {

/// Whether a server with this description answers a search with the parameter (knx.md, section 3.4).
bool matches(const ServerDescription& about, const Srp& srp) {
  switch (srp.type) {
    case Srp::Type::kWantedDibs: return true;
    case Srp::Type::kProgrammingMode: return about.programming_mode;
    case Srp::Type::kMac: return std::equal(srp.content.begin(), srp.content.end(), about.mac.begin(), about.mac.end());
    case Srp::Type::kFamily:
      return srp.content.size() == 2 && srp.content[1] != 0 && about.version(Family(srp.content[0])) >= srp.content[1];
  }
  return false;
}

}  // namespace

ServerDescription Server::description() const {
  ServerDescription about;
  about.medium = 0x02;  // TP1
  about.address = IndividualAddress(options_.own_address);
  about.name = options_.name;
  about.families = {{Family::kCore, std::uint8_t(max_apdu ? 2 : 1)},
                    {Family::kTunnelling, std::uint8_t(options_.wanted_addresses ? 2 : 1)}};
  if (sessions_) about.families.push_back({Family::kSecurity, 1});
  for (std::size_t i = 0; i < options_.tunnels; ++i)
    about.addresses.push_back(IndividualAddress(static_cast<std::uint16_t>(options_.first_address + i)));
  return about;
}

/// A description does not name secured families and free tunnels; the answer to an extended search does.
void Server::describe(const Peer& from, const Hpai& control) {
  send(peer_of(from, control), DescriptionResponse{to_dibs(description())});
}

void Server::found(const Peer& from, const SearchRequest& request) {
  if (!request.extended || !max_apdu) return;
  auto about = description();
  const auto misses = [&](const Srp& srp) { return srp.mandatory && !matches(about, srp); };
  if (std::any_of(request.parameters.begin(), request.parameters.end(), misses)) return;
  const bool secured = sessions_ && sessions_->options().required;
  if (secured) about.secured = {{Family::kTunnelling, 1}};
  about.max_apdu = max_apdu;
  for (const auto address : about.addresses) about.slots.push_back({address, true, !secured, !in_use(number(address))});
  send(peer_of(from, request.discovery), SearchResponse{Hpai{}, true, to_dibs(about)});
}

/// Over UDP the request would be acknowledged as a tunnelled one; no client here sends it there.
void Server::tell_feature(const Peer& from, const FeatureMessage& request) {
  const auto* channel = channel_of(from, request.header.channel);
  const bool asked = request.service == ServiceCode::kFeatureGet && from.stream;
  if (!max_apdu || channel == nullptr || !asked || request.feature != std::uint8_t(Feature::kMaxApdu)) return;
  Bytes value;
  write_u16(value, *max_apdu);
  send(channel->data,
       FeatureMessage{ServiceCode::kFeatureResponse, {request.header.channel, 0, 0}, request.feature, 0, value}, true);
}

}  // namespace rubicon::knx_simulator
