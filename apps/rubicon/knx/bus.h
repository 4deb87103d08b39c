#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/rubicon/session.h"

namespace rubicon::cli::knx {

/// Where `monitor`, `read`, `write` and `capture` get to the bus.
struct BusOptions {
  std::string direct;  ///< host or host:port of a KNXnet/IP interface; empty = through the running island
  bool tcp = false;    ///< of `direct`
  std::uint32_t island = 0;
  std::string network;  ///< id; empty = the only one of type knx
};

/// A way to a KNX network, which takes requests and says answers and telegrams (docs/knx.md, "Tools").
class Bus {
 public:
  /// nullptr: why not was said on standard error; `code` is then the program's.
  static std::unique_ptr<Bus> open(const Settings& settings, const BusOptions& options, std::string_view command,
                                   int& code);
  virtual ~Bus() = default;

  virtual void ask(const nlohmann::json& request) = 0;
  /// Waits as Session::run does.
  virtual bool run(const std::function<bool()>& done, Duration patience = Duration::max()) = 0;
  virtual bool interrupted() const = 0;
  virtual Output& out() = 0;

  /// The answer to a request, or one with `why` when none came in time.
  nlohmann::json answer_to(nlohmann::json request, Duration patience);

  std::function<void(const nlohmann::json& telegram)> on_telegram;
  std::function<void(const nlohmann::json& reply)> on_reply;
  /// The line to the bus came back, or was lost and why. Only of a tunnel of our own.
  std::function<void(bool up, const std::string& why)> on_line;

 protected:
  /// What came with one of the tags of networks/knx/tool_requests.h.
  void take(std::string_view tag, std::string_view text);
};

}  // namespace rubicon::cli::knx
