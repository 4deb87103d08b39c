#pragma once

#include <functional>
#include <list>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "base/scheduler.h"
#include "network/line_reports.h"
#include "network/network.h"
#include "networks/knx/capture.h"
#include "networks/knx/dpt/dpt.h"
#include "networks/knx/line/line.h"

namespace rubicon::networks::knx {

/// Tags of the Opaque messages between tools and this network; the bytes are JSON (docs/knx.md, "Tools").
inline constexpr std::string_view kRequestTag = "knx.request";
inline constexpr std::string_view kReplyTag = "knx.reply";
inline constexpr std::string_view kTelegramTag = "knx.telegram";

/// Serves diagnostic tools that share the network's line: read, write, monitor, capture. Answers every request once.
class ToolRequests {
 public:
  static constexpr std::size_t kMaxReads = 64;

  /// What is known of a group address: its configured name and type, empty for other addresses.
  struct Meaning {
    std::string name;
    const dpt::Dpt* dpt = nullptr;
    std::string address;   ///< in the notation of the project
    bool secured = false;  ///< only secured telegrams are taken and sent (KNX Data Secure)
  };
  using FindMeaning = std::function<Meaning(wire::GroupAddress)>;
  /// The tuple whose commands the group address carries: `actuator.switch-1.command of device 1/4/6`; empty: none.
  using FindCommand = std::function<std::string(wire::GroupAddress)>;

  /// Called for each write that the bus confirmed.
  using Wrote = std::function<void(const wire::Telegram&)>;

  ToolRequests(network::NetworkHost& host, const Capture& capture, FindMeaning find_meaning, FindCommand find_command,
               Wrote wrote);

  /// Sends telegrams over this line; nullptr: requests that need it are refused.
  void use(line::Line* line);
  /// Refuses to write what commands an actuator where the message names the member who sent it: a member that may send
  /// need not be allowed to set (docs/decisions/015-messages-of-others.md). kUnsupported if the message is not a
  /// request of a tool, kInvalid if it cannot be read.
  Result<void> receive(const model::Message& message);
  bool monitored() const { return monitors_.any(); }
  /// A telegram was received, or is sent (`own`).
  void seen(const wire::Telegram& telegram, bool own);

 private:
  struct Requester {
    Address address;
    std::string id;          ///< of the request; the reply repeats it
    bool is_member = false;  ///< of the ecology: rights say what it may set
  };
  struct OpenRead {
    Requester requester;
    wire::GroupAddress address{};
    const dpt::Dpt* dpt = nullptr;
    Timer timeout;
  };
  void read(Requester requester, const nlohmann::json& request);
  void write(Requester requester, const nlohmann::json& request);
  void monitor(const Requester& requester, const nlohmann::json& request);
  void capture(const Requester& requester, const nlohmann::json& request);
  void reply(const Requester& requester, nlohmann::json answer);
  void refuse(const Requester& requester, std::string_view why);
  void give_up(wire::GroupAddress address, std::string_view why);
  nlohmann::json described(const wire::Telegram& telegram, bool own) const;

  network::NetworkHost& host_;
  const Capture& capture_;
  FindMeaning find_meaning_;
  FindCommand find_command_;
  Wrote wrote_;
  line::Line* line_ = nullptr;
  std::list<OpenRead> reads_;
  network::Monitors monitors_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::knx
