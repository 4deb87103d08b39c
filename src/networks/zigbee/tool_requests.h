#pragma once

#include <functional>
#include <list>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "network/line_reports.h"
#include "network/network.h"
#include "networks/zigbee/bridge/messages.h"
#include "networks/zigbee/device_table.h"

namespace rubicon::networks::zigbee {

/// Tags of the Opaque messages between tools and this network; the bytes are JSON (docs/zigbee.md, "Tools").
inline constexpr std::string_view kRequestTag = "zigbee.request";
inline constexpr std::string_view kAdminTag = "zigbee.admin";  ///< for all requests
inline constexpr std::string_view kReplyTag = "zigbee.reply";
inline constexpr std::string_view kEventTag = "zigbee.event";
inline constexpr std::string_view kMessageTag = "zigbee.message";  ///< to those who watch

/// The tag that a request needs: kAdminTag if it changes the installation (permit, rename, remove, options with `set`),
/// else kRequestTag.
std::string_view tag_of(const nlohmann::json& request);

/// Serves tools that manage the bridge: permit, devices, rename, remove, options, map, health; and monitor, which shows
/// what passes. Answers every request once.
class ToolRequests {
 public:
  static constexpr std::size_t kMaxOpen = 64, kMaxWatching = 16;
  /// For the bridge's answer (zigbee.md, section 8: unknown requests get none).
  static constexpr Duration kAnswerTime = std::chrono::seconds(10), kMapTime = std::chrono::minutes(2);
  static constexpr std::size_t kMaxShown = 1000;  ///< bytes of a payload that those who watch see
  /// How long a map is kept for tools that read it in parts.
  static constexpr Duration kMapLife = std::chrono::minutes(5);

  /// Publishes to `bridge/request/<what>`.
  using Publish = std::function<Result<void>(std::string_view what, std::string payload)>;

  /// `requester` names this network among all clients of the bridge. `trouble`: line_trouble() of the network.
  ToolRequests(network::NetworkHost& host, std::string requester, const DeviceTable& devices, Publish publish,
               std::function<std::string()> trouble);

  /// Whether the bridge is there, or why not: requests that wait are then refused.
  void use(bool up, const std::string& why);
  /// kUnsupported if the message is not a request of a tool, kRefused if it names a device, kInvalid if it cannot be
  /// read. A member that may send to one device must not reach the others.
  Result<void> receive(const Message& message);

  /// The broker did not take a message to this topic: requests that wait for its answer are refused.
  void not_taken(std::string_view topic, const std::string& why);

  /// A message that the island got or sent, for those who watch; `topic` without that of the bridge in front.
  void passed(std::string_view topic, std::string_view payload, bool outgoing);

  // What the bridge publishes.
  void response(std::string_view payload);
  void event(const bridge::BridgeEvent& event);
  void info(std::string_view payload, const bridge::BridgeDescription& info);
  void health(std::string_view payload) { health_ = payload; }

  /// What `bridge/info` says, for State::texts: `bridge`, `settings`.
  const std::map<std::string, std::string>& texts() const { return texts_; }

 private:
  struct Requester {
    Address address;
    std::string id;  ///< of the request; the reply repeats it
  };
  using Done = std::function<void(const Requester& requester, const bridge::BridgeResponse& response)>;
  struct Open {
    Requester requester;
    std::string what, transaction;
    Done done;
    Timer timeout;
  };
  /// A tool that sees devices join.
  struct Watching {
    Requester requester;
    bool open = false;  ///< Zigbee2MQTT reported that devices may join
    Timer end;
  };
  /// A device or group as requests name it.
  struct Target {
    std::string address;
    std::string id;  ///< of the bridge: `0x00124b0010000000`, or the number of a group
    bool group = false;
  };

  bool may_watch(const Requester& requester) const;
  void answer(Requester requester, const nlohmann::json& request);
  void permit(Requester requester, const nlohmann::json& request);
  void permitted(const Requester& requester, std::int64_t seconds);
  void devices(const Requester& requester, const nlohmann::json& request);
  std::string why_unlisted() const;
  void rename(Requester requester, const nlohmann::json& request);
  void remove(Requester requester, const nlohmann::json& request);
  void options(Requester requester, const nlohmann::json& request);
  void map(Requester requester, const nlohmann::json& request);
  void send_map(const Requester& requester, std::size_t from);
  void health_check(Requester requester);
  void monitor(const Requester& requester, const nlohmann::json& request);
  nlohmann::json described(const bridge::DeviceRecord& record, const std::string& why) const;

  /// The device that the request names in `field`, or by the `address` that the word has on the island. nullopt: the
  /// request was refused.
  std::optional<Target> target(const Requester& requester, const nlohmann::json& request, const char* field);
  void ask(Requester requester, std::string_view what, nlohmann::json payload, Duration time, Done done);
  void close_watching(std::string_view why);
  void reply(const Requester& requester, nlohmann::json answer);
  void refuse(const Requester& requester, std::string_view why);
  void send(const Address& to, std::string_view tag, const nlohmann::json& content);

  network::NetworkHost& host_;
  std::string requester_;
  const DeviceTable& devices_;
  Publish publish_;
  std::function<std::string()> trouble_;
  std::string down_;  ///< why the bridge is not there; empty = it is
  std::uint64_t last_transaction_ = 0;
  std::list<Open> open_;
  std::list<Watching> watching_;
  network::Monitors monitors_;
  bool joining_ = false;       ///< the newest permit_join of bridge/info
  std::string info_, health_;  ///< the newest payloads, read when a tool asks
  std::map<std::string, std::string> texts_;
  std::optional<bridge::NetworkMap> map_;
  Timer map_end_;
};

}  // namespace rubicon::networks::zigbee
