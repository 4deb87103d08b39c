#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "apps/rubicon/session.h"
#include "apps/rubicon/targets/options.h"

namespace rubicon::cli {

/// The messages between the tools of a network type and its networks: tags of Opaque messages whose bytes are JSON.
struct ToolTags {
  std::string_view request, reply, event;
  /// The tag of one request; nullptr = `request`, whatever it is.
  std::string_view (*request_tag)(const nlohmann::json& request) = nullptr;

  std::string_view tag_of(const nlohmann::json& asked) const { return request_tag ? request_tag(asked) : request; }
};

/// The island and the network that a tool talks to.
struct NetworkChoice {
  std::string type{};     ///< `knx`
  IslandOption island{};  ///< any, unless one is named
  std::string network{};  ///< id, also with its island in front; empty = the only one of the type

  /// Adds --island and --network; the second option.
  CLI::Option* add_to(CLI::App* app, const std::string& example);
};

/// A connection of a tool to a network: requests, their replies, and events of the network.
class ToolLine {
 public:
  explicit ToolLine(const ToolTags& tags) : tags_(tags) {}
  virtual ~ToolLine() = default;
  ToolLine(const ToolLine&) = delete;
  ToolLine& operator=(const ToolLine&) = delete;

  virtual void send(const nlohmann::json& request) = 0;
  /// Runs the event loop as Session::run does.
  virtual bool run(const std::function<bool()>& done, Duration patience = Duration::max()) = 0;
  virtual bool interrupted() const = 0;
  /// After an interrupt: run() waits again, until the next signal.
  virtual void resume() = 0;
  virtual Output& out() = 0;
  /// The devices that the island lists for the network; none for a line of the tool's own.
  virtual std::vector<client::Device> devices() { return {}; }

  /// Sends a request and waits for its reply; a timeout gives a reply with `why`.
  nlohmann::json reply_to(nlohmann::json request, Duration patience);

  std::function<void(const nlohmann::json& event)> on_event;
  std::function<void(const nlohmann::json& reply)> on_reply;
  /// The line is up again, or was lost and why. Only called for a line of the tool's own.
  std::function<void(bool up, const std::string& why)> on_line;

 protected:
  const ToolTags& tags() const { return tags_; }
  /// Passes a message with one of the tags to its callback.
  void receive(std::string_view tag, std::string_view text);

 private:
  ToolTags tags_;
};

/// Through a running island. nullptr: the error was printed, and `code` is the exit code.
std::unique_ptr<ToolLine> open_tool_line(const Settings& settings, std::string_view command, NetworkChoice choice,
                                         const ToolTags& tags, int& code);

/// Asks the network for its traffic, which `line.on_event` gets, until a signal. The exit code.
int monitor_traffic(ToolLine& line);

/// Prints the reason of a reply that refuses; kNotDone.
int refused(const nlohmann::json& reply);

}  // namespace rubicon::cli
