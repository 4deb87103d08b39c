#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "networks/knx/wire/message.h"
#include "transport/udp.h"

namespace rubicon::networks::knx::line {

/// What a server demands of the services that islands use, tunnelling and routing.
enum class Security : std::uint8_t {
  kUnknown,   ///< it did not answer an extended search, which alone says it
  kNone,      ///< it does not know KNX IP Secure
  kPossible,  ///< it knows KNX IP Secure and takes plain connections too
  kRequired   ///< tunnelling, routing or both are secure only: ServerDescription::secured
};
/// `unknown`, `none`, `possible`, `required`.
std::string_view to_string(Security security);

/// A KNXnet/IP server, described by its answers to searches and description requests.
struct FoundServer {
  transport::Endpoint control;  ///< identifies the server
  wire::ServerDescription description;
  bool extended = false;  ///< it answered an extended search: a server of Core version 2

  std::size_t free_slots() const;
  Security security() const;
  friend bool operator==(const FoundServer&, const FoundServer&) = default;
};

/// Adds the contents of another answer of the same server. Values that an answer leaves out stay: knxd reports family
/// 03 only in its description, and a serial number only in its search answer (knx.md, 5.2).
void merge(wire::ServerDescription& into, const wire::ServerDescription& more);

/// Answers of any number of servers, one entry per control endpoint, in order of arrival.
class FoundServers {
 public:
  /// A KNX network of the largest size has fewer routers.
  static constexpr std::size_t kMaxServers = 1024;

  /// False if the server was not added because there are kMaxServers.
  bool add(const transport::Endpoint& control, const wire::ServerDescription& description, bool extended);
  const std::vector<FoundServer>& all() const { return servers_; }

 private:
  std::vector<FoundServer> servers_;
};

/// `TP1`, `IP`, `medium 40`, `unknown medium`.
std::string medium_name(std::uint8_t medium);

/// Several lines for the user, without a final line end.
std::string describe(const FoundServer& server);

}  // namespace rubicon::networks::knx::line
