#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "networks/knx/line/found_server.h"
#include "rubicon/result.hpp"
#include "transport/transports.h"

namespace rubicon::networks::knx::line {

/// System group of KNXnet/IP, and the port of all its services (KNX 3/8/2).
constexpr std::string_view kKnxGroup = "224.0.23.12";
constexpr std::uint16_t kKnxPort = 3671;

struct DiscoveryOptions {
  /// IPv4 addresses of the interfaces that are searched; empty = no search.
  std::vector<std::string> interfaces{};
  /// Names or numeric addresses of those asked for their description: works where multicast does not.
  std::vector<transport::Endpoint> hosts{};
  transport::Endpoint group{std::string(kKnxGroup), kKnxPort};
  std::uint8_t ttl = 16;
  /// Ask for answers to where the question came from, for networks with address translation.
  bool route_back = false;
  Duration collect = std::chrono::seconds(3);      ///< answers of a search come within this time
  Duration repeat = std::chrono::seconds(1);       ///< after this time the search is said once more
  Duration description = std::chrono::seconds(3);  ///< so long each of two requests for a description waits
};

struct DiscoveryResult {
  std::vector<FoundServer> servers;  ///< by control endpoint
  std::vector<Error> problems;       ///< interfaces that cannot be searched, hosts that do not answer
  std::uint64_t bad_frames = 0;      ///< heard, but no answer we could read
};

/// Looks for KNXnet/IP servers once, by SEARCH_REQUEST and SEARCH_REQUEST_EXTENDED, and by DESCRIPTION_REQUEST,
/// followed by an extended search where the server knows that (KNX 3/8/2, 7.6 and 7.7). Destroyed = ended, `done` is
/// not called.
class Discovery {
 public:
  /// Called once, in a later turn. The discovery may be destroyed in it.
  using Done = std::function<void(DiscoveryResult)>;

  /// Begins. Scheduler and transports must outlive it.
  Discovery(Scheduler& scheduler, transport::Transports& transports, DiscoveryOptions options, Done done);
  ~Discovery();
  Discovery(const Discovery&) = delete;
  Discovery& operator=(const Discovery&) = delete;

  /// A frame of a search that was heard elsewhere (on the routing socket); others are ignored.
  void heard(const transport::Endpoint& from, ByteView frame);

 private:
  struct Search;
  struct Question;

  void search(const std::string& interface_address);
  void say(Search& search);
  void ask(const transport::Endpoint& host);
  void resolved(Question& question, const Result<std::vector<std::string>>& addresses);
  void open(Question& question);
  void send(Question& question);
  void unanswered(Question& question, const std::string& why);
  void ask_more(Question& question);
  void end(Question& question);
  void answered(Question& question, const transport::Endpoint& from, ByteView frame);
  void problem(Error error);
  void finish_if_done();

  Scheduler& scheduler_;
  transport::Transports& transports_;
  DiscoveryOptions options_;
  Done done_;
  std::vector<std::unique_ptr<Search>> searches_;
  std::vector<std::unique_ptr<Question>> questions_;
  FoundServers servers_;
  DiscoveryResult result_;
  bool collecting_ = false;
  Timer repeat_, end_, finish_;
};

}  // namespace rubicon::networks::knx::line
