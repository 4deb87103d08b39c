#pragma once

#include <functional>
#include <list>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "network/network.h"
#include "networks/knx/capture.h"
#include "networks/knx/dpt/dpt.h"
#include "networks/knx/line/line.h"

namespace rubicon::networks::knx {

/// Tags of the Opaque messages between tools and this network; the bytes are JSON (docs/knx.md, "Tools").
inline constexpr std::string_view kRequestTag = "knx.request";
inline constexpr std::string_view kReplyTag = "knx.reply";
inline constexpr std::string_view kTelegramTag = "knx.telegram";

/// Serves people with tools who share the network's line: read, write, monitor, capture. Answers every request once.
class Operators {
 public:
  static constexpr std::size_t kMostMonitors = 16;
  static constexpr std::size_t kMostReads = 64;
  static constexpr Duration kLongestMonitor = std::chrono::minutes(10);

  /// Name and type of a group address, as configured; empty where it is not.
  struct Meaning {
    std::string name;
    const dpt::Dpt* dpt = nullptr;
  };
  using Means = std::function<Meaning(wire::GroupAddress)>;

  /// Told of each write that the bus has.
  using Wrote = std::function<void(const wire::Telegram&)>;

  Operators(network::NetworkHost& host, const Capture& capture, Means means, Wrote wrote);

  /// Requests go over this line; nullptr: they are refused.
  void use(line::Line* line);
  /// A message to the network; kUnsupported if it is no request of a tool, kInvalid if it cannot be read.
  Result<void> take(const model::Message& message);
  bool monitored() const { return !monitors_.empty(); }
  /// A telegram was heard, or is sent.
  void seen(const wire::Telegram& telegram, bool own);

 private:
  struct Asker {
    Address address;
    std::string id;  ///< of the request, in his own words
  };
  struct Reading {
    Asker asker;
    wire::GroupAddress address{};
    const dpt::Dpt* dpt = nullptr;
    Timer patience;
  };
  struct Monitor {
    Asker asker;
    Timer lease;
  };
  void read(Asker asker, const nlohmann::json& wish);
  void write(Asker asker, const nlohmann::json& wish);
  void monitor(Asker asker, const nlohmann::json& wish);
  void capture(const Asker& asker, const nlohmann::json& wish);
  void reply(const Asker& asker, nlohmann::json answer);
  void refuse(const Asker& asker, std::string_view why);
  void give_up(wire::GroupAddress address, std::string_view why);
  void say(const Address& to, std::string_view tag, const std::string& text);
  nlohmann::json described(const wire::Telegram& telegram, bool own) const;

  network::NetworkHost& host_;
  const Capture& capture_;
  Means means_;
  Wrote wrote_;
  line::Line* line_ = nullptr;
  std::list<Reading> readings_;
  std::list<Monitor> monitors_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
};

}  // namespace rubicon::networks::knx
