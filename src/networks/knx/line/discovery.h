#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/scheduler.h"
#include "networks/knx/wire/message.h"
#include "rubicon/result.hpp"
#include "transport/sockets.h"
#include "transport/transports.h"

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

/// System group of KNXnet/IP, and the port of all its services (KNX 3/8/2).
constexpr std::string_view kKnxGroup = "224.0.23.12";
constexpr std::uint16_t kKnxPort = 3671;

struct DiscoveryOptions {
  /// IPv4 addresses of the interfaces to search; empty = no search.
  std::vector<std::string> interfaces{};
  /// Names or numeric addresses of servers to ask for their description: works without multicast.
  std::vector<transport::Endpoint> hosts{};
  transport::Endpoint group{std::string(kKnxGroup), kKnxPort};
  std::uint8_t ttl = 16;
  /// Servers answer to the source of the request, for networks with address translation.
  bool route_back = false;
  Duration collect = std::chrono::seconds(3);      ///< how long answers to a search are collected
  Duration repeat = std::chrono::seconds(1);       ///< when the search is sent a second time
  Duration description = std::chrono::seconds(3);  ///< timeout of each of the two description requests
};

struct DiscoveryResult {
  std::vector<FoundServer> servers;  ///< by control endpoint
  std::vector<Error> problems;       ///< interfaces that cannot be searched, hosts that do not answer
  std::uint64_t bad_frames = 0;      ///< received frames that are no readable answer
};

/// Searches for KNXnet/IP servers once, by SEARCH_REQUEST and SEARCH_REQUEST_EXTENDED, and by DESCRIPTION_REQUEST,
/// followed by an extended search where the server supports that (KNX 3/8/2, 7.6 and 7.7). Destruction ends the search;
/// `done` is then not called.
class Discovery {
 public:
  /// Called once, in a later turn. The call may destroy the discovery.
  using Done = std::function<void(DiscoveryResult)>;

  /// Starts the search. Scheduler and transports must outlive it.
  Discovery(Scheduler& scheduler, transport::Transports& transports, DiscoveryOptions options, Done done);
  ~Discovery();
  Discovery(const Discovery&) = delete;
  Discovery& operator=(const Discovery&) = delete;

  /// A frame of a search that the socket of routing received; other frames are ignored.
  void receive(const transport::Endpoint& from, ByteView frame);

 private:
  struct Search;
  struct Query;

  void search(const std::string& interface_address);
  void send_search(Search& search);
  void ask_host(const transport::Endpoint& host);
  void resolved(Query& query, const Result<std::vector<std::string>>& addresses);
  void open(Query& query);
  void send(Query& query);
  void unanswered(Query& query, const std::string& why);
  void search_host(Query& query);
  void end(Query& query);
  void answered(Query& query, const transport::Endpoint& from, ByteView frame);
  void problem(Error error);
  void finish_if_done();

  Scheduler& scheduler_;
  transport::Transports& transports_;
  DiscoveryOptions options_;
  Done done_;
  std::vector<std::unique_ptr<Search>> searches_;
  std::vector<std::unique_ptr<Query>> queries_;
  FoundServers servers_;
  DiscoveryResult result_;
  bool collecting_ = false;
  Timer repeat_, end_, finish_;
};

}  // namespace rubicon::networks::knx::line
