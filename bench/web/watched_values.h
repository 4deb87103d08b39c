#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "web/web_client.h"

namespace rubicon::bench::web {

/// What clients of both kinds have seen of the generated points.
struct Seen {
  std::uint64_t updates = 0, messages = 0, bytes = 0;
  std::vector<double> ages_ms;      ///< of the newest value in each message, when it arrived
  std::vector<std::string> values;  ///< the latest of each point

  /// Forgets all but the values.
  void restart();
  /// Points that do not have the value of their last update, when so many were made, of them `before` before the
  /// client was there: a broker does not repeat those.
  std::size_t wrong(std::uint64_t made, std::uint64_t before) const;
};

/// Follows the generated values by a WebSocket.
class ValuesClient {
 public:
  virtual ~ValuesClient() = default;

  /// Reads for so long.
  void watch(Clock::duration span);
  /// Reads until nothing came for half a second.
  void settle();
  Seen seen;

 protected:
  /// False: no message came by then.
  virtual bool take(Clock::time_point until) = 0;
};

/// A client of the page's WebSocket that follows all values.
class PageClient final : public ValuesClient {
 public:
  /// Returns after the snapshot.
  PageClient(int port, int devices);

 private:
  bool take(Clock::time_point until) override;

  WebClient client_;
  std::vector<std::size_t> points_;  ///< by the numbers of their keys
  bool complete_ = false;
};

/// A client of mosquitto's WebSocket (MQTT 3.1.1) that follows all values.
class BrokerClient final : public ValuesClient {
 public:
  BrokerClient(int port, int devices);

 private:
  bool take(Clock::time_point until) override;
  void publication(std::string_view packet);

  WebClient client_;
  std::string pending_;
  bool subscribed_ = false;
};

}  // namespace rubicon::bench::web
