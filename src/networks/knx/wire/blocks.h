#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.h"
#include "networks/knx/wire/address.h"
#include "rubicon/result.hpp"

namespace rubicon::networks::knx::wire {

/// Status codes that the state machines handle (KNX 3/8/2, 7.8; 3/8/4).
namespace status {
constexpr std::uint8_t kOk = 0x00, kUnknownConnection = 0x21, kConnectionType = 0x22, kNoMoreConnections = 0x24,
                       kNoUniqueConnection = 0x25, kBusDown = 0x27, kUnauthorised = 0x28, kLayer = 0x29,
                       kAddressInUse = 0x2e;
}  // namespace status

/// What a client does about a status.
enum class Remedy : std::uint8_t {
  kNone,           ///< not an error
  kReconnect,      ///< connect again at once: the server has forgotten the connection
  kRetry,          ///< connect again after a growing pause
  kWaitForSlot,    ///< another client has the tunnel or address: report it, retry after a growing pause
  kConfiguration,  ///< only a change of configuration helps: report it, retry rarely
  kBusDown,        ///< the connection works, the bus does not: keep the connection
};

struct StatusMeaning {
  std::string_view meaning;  ///< text for the user
  Remedy remedy = Remedy::kRetry;
};

/// The meaning of a status in a response of the server. The remedy of unknown codes is kRetry.
StatusMeaning meaning_of(std::uint8_t status);
/// `all tunnels of the interface are in use (status 24)`.
std::string describe_status(std::uint8_t status);

/// Building blocks of KNXnet/IP bodies (KNX 3/8/2, section 7.5). read_x() consumes its block from `reader`;
/// kInvalid names the block and the error. write() appends.

enum class HostProtocol : std::uint8_t { kUdp = 1, kTcp = 2 };

/// Host protocol address: an IPv4 endpoint. All zero = route back: answers go to the source of the datagram (NAT, TCP).
struct Hpai {
  HostProtocol protocol = HostProtocol::kUdp;
  std::array<std::uint8_t, 4> address{};
  std::uint16_t port = 0;

  /// True if address or port is zero, so nothing can be sent there.
  bool route_back() const { return address == std::array<std::uint8_t, 4>{} || port == 0; }
  friend bool operator==(const Hpai&, const Hpai&) = default;
};

/// From a numeric IPv4 address; route back for any other text.
Hpai udp_hpai(std::string_view address, std::uint16_t port);
/// `10.77.0.1`.
std::string address_text(const Hpai& hpai);
Result<Hpai> read_hpai(base::ByteReader& reader);
void write(Bytes& out, const Hpai& hpai);

/// Connection header of tunnelling and device configuration frames.
struct ConnectionHeader {
  std::uint8_t channel = 0, sequence = 0;
  std::uint8_t status = 0;  ///< of an ack; 0 in requests
  friend bool operator==(const ConnectionHeader&, const ConnectionHeader&) = default;
};
Result<ConnectionHeader> read_connection_header(base::ByteReader& reader);
void write(Bytes& out, const ConnectionHeader& header);

enum class ConnectionType : std::uint8_t { kDeviceManagement = 3, kTunnel = 4 };
enum class TunnelLayer : std::uint8_t { kLink = 0x02, kRaw = 0x04, kBusMonitor = 0x80 };

/// Connection request information. Types other than those of ConnectionType are kUnsupported.
struct Cri {
  ConnectionType type = ConnectionType::kTunnel;
  TunnelLayer layer = TunnelLayer::kLink;     ///< of a tunnel
  std::optional<IndividualAddress> wanted{};  ///< of a tunnel: extended form, Tunnelling version 2 only
  friend bool operator==(const Cri&, const Cri&) = default;
};
Result<Cri> read_cri(base::ByteReader& reader);
void write(Bytes& out, const Cri& cri);

/// Connection response data.
struct Crd {
  ConnectionType type = ConnectionType::kTunnel;
  IndividualAddress address{};  ///< of a tunnel
  friend bool operator==(const Crd&, const Crd&) = default;
};
Result<Crd> read_crd(base::ByteReader& reader);
void write(Bytes& out, const Crd& crd);

/// Search request parameter: what a server must match to answer an extended search.
struct Srp {
  enum class Type : std::uint8_t { kProgrammingMode = 1, kMac = 2, kFamily = 3, kWantedDibs = 4 };
  Type type = Type::kWantedDibs;  ///< other types are kept unchanged
  bool mandatory = false;         ///< servers that do not match do not answer
  Bytes content;                  ///< by type: MAC (6 bytes); family and version; an even number of DIB types
  friend bool operator==(const Srp&, const Srp&) = default;
};
/// All blocks up to the end of `reader`.
Result<std::vector<Srp>> read_srps(base::ByteReader& reader);
void write(Bytes& out, const Srp& srp);

void write_u16(Bytes& out, std::uint16_t value);

}  // namespace rubicon::networks::knx::wire
