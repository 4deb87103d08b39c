#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "network/line_reports.h"

namespace rubicon::networks::wsn {

/// Tags of the Opaque messages between tools and this network; the bytes are JSON (docs/motes.md, "Watching packets").
inline constexpr std::string_view kRequestTag = "wsn.request";
inline constexpr std::string_view kReplyTag = "wsn.reply";
inline constexpr std::string_view kPacketTag = "wsn.packet";

/// Shows the packets between the island and its sink to programs that ask for them. Answers every request once.
class PacketMonitor {
 public:
  /// `up`: whether the sink is there, for the replies.
  PacketMonitor(network::NetworkHost& host, std::function<bool()> up)
      : host_(host), up_(std::move(up)), monitors_(host) {}

  /// kInvalid for bytes that are no JSON object.
  Result<void> receive(const model::Message& message);
  void received(ByteView packet) { show(packet, false); }
  void sent(ByteView packet) { show(packet, true); }

 private:
  void show(ByteView packet, bool outgoing);

  network::NetworkHost& host_;
  std::function<bool()> up_;
  network::Monitors monitors_;
};

}  // namespace rubicon::networks::wsn
