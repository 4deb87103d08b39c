#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/rubicon/session.h"

namespace rubicon::cli::knx {

/// How `monitor`, `read`, `write` and `capture` reach the bus.
struct BusOptions {
  std::string direct;  ///< HOST or HOST:PORT of a KNXnet/IP interface; empty = through the running island
  bool tcp = false;    ///< with `direct`: by TCP, else UDP
  std::uint32_t island = 0;
  std::string network;  ///< id; empty = the only one of type knx
};

/// A connection to a KNX network, for requests, their replies and received telegrams (docs/knx.md, "Tools").
class Bus {
 public:
  /// nullptr: the error was printed, and `code` is the exit code.
  static std::unique_ptr<Bus> open(const Settings& settings, const BusOptions& options, std::string_view command,
                                   int& code);
  virtual ~Bus() = default;

  virtual void send(const nlohmann::json& request) = 0;
  /// Runs the event loop as Session::run does.
  virtual bool run(const std::function<bool()>& done, Duration patience = Duration::max()) = 0;
  virtual bool interrupted() const = 0;
  virtual Output& out() = 0;

  /// Sends a request and waits for its reply; a timeout gives a reply with `why`.
  nlohmann::json reply_to(nlohmann::json request, Duration patience);

  std::function<void(const nlohmann::json& telegram)> on_telegram;
  std::function<void(const nlohmann::json& reply)> on_reply;
  /// The line is up again, or was lost and why. Only called with `--direct`.
  std::function<void(bool up, const std::string& why)> on_line;

 protected:
  /// Passes a message with one of the tags of networks/knx/tool_requests.h to its callback.
  void receive(std::string_view tag, std::string_view text);
};

}  // namespace rubicon::cli::knx
