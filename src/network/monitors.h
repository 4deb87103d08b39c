#pragma once

#include <list>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "network/network.h"

namespace rubicon::network {

/// Programs that watch the traffic of a line. Each asks with `{"do": "monitor", "id": ..., "seconds": ...}`, and gets
/// every message until its lease ends, at most ten minutes later. The same program and id renew the lease; 0 seconds
/// end it.
class Monitors {
 public:
  static constexpr std::size_t kMost = 16;
  static constexpr Duration kLongest = std::chrono::minutes(10);
  static constexpr Duration kUsual = std::chrono::seconds(30);  ///< without `seconds`

  /// The host must outlive it.
  explicit Monitors(NetworkHost& host) : host_(host) {}

  /// kBusy if too many are open.
  Result<void> ask(const Address& program, const std::string& id, const nlohmann::json& request);
  bool any() const { return !all_.empty(); }
  /// To each of them, as an Opaque message with this tag.
  void send(std::string_view tag, std::string_view text);

 private:
  struct Monitor {
    Address program;
    std::string id;
    Timer lease;
  };
  NetworkHost& host_;
  std::list<Monitor> all_;
};

/// A text as an Opaque message to another component.
void send_text(NetworkHost& host, const Address& to, std::string_view tag, std::string_view text);

}  // namespace rubicon::network
