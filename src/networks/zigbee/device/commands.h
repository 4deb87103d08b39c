#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/scheduler.h"
#include "model/message.h"
#include "rubicon/result.hpp"

namespace rubicon::networks::zigbee::device {

/// A command on its way to the device.
struct Command {
  std::uint64_t request = 0;
  std::size_t point = 0, property = 0;
  std::string key, json;  ///< as in the set message
  Value value;            ///< as commanded
  Value wanted;           ///< as the property can hold it: what `json` means
  bool event = false;     ///< each one counts; else a newer one for the same property supersedes it
  bool echoed = true;     ///< Zigbee2MQTT publishes the value after it was sent; false: the broker's answer is all
  SteadyTime expires{};   ///< until then it must be published
  SteadyTime answer_by{};
  WallTime published{};
  std::uint64_t message = 0;  ///< number of its set message
};

/// The commands of a device until Zigbee2MQTT confirmed that it sent them: merges them into `set` messages, waits for
/// the echo, and answers each one exactly once (zigbee.md, sections 5 and 9). There is no negative reply to a set, so
/// that a time-out must do. A command without an echo is sent when the broker took its message, or said nothing of it
/// for kEchoTime. The broker answers the messages of a connection in their order (MQTT 5, section 4.6).
class Commands {
 public:
  /// How long commands wait for the echo of the set before them. A set that Zigbee2MQTT rejected has no echo: with a
  /// longer wait the commands behind it would expire.
  static constexpr Duration kHold = std::chrono::seconds(2);
  /// Radio attempts take up to 10 s (zigbee.md, section 5).
  static constexpr Duration kEchoTime = std::chrono::seconds(15);
  /// Every request is answered by then (network::Network::send): a second before the proxy, whose wait of 30 s began
  /// earlier, gives the command up.
  static constexpr Duration kAnswerTime = std::chrono::seconds(29);
  static constexpr std::size_t kMaxPending = 200;

  struct Callbacks {
    std::function<Result<void>(std::string payload)> publish;
    std::function<void(std::uint64_t request, model::Outcome outcome, std::string text)> answer;
    /// Published; from now on its value may come back. Before it is answered.
    std::function<void(const Command& command)> published;
  };
  Commands(Scheduler& scheduler, Callbacks calls);

  /// Published at the end of this turn, or when the set before it has its echo. kBusy: too many wait.
  Result<void> add(Command command, bool sleeps, Duration time_to_live);
  /// The oldest published command for the property that waits for its echo; nullptr if there is none.
  const Command* awaiting(std::size_t property) const;
  /// Its value came back: answers it and forgets it.
  void echo(const Command& command);
  /// The broker took the oldest set message that it did not answer yet.
  void taken();
  /// It did not take it: refuses its commands.
  void not_taken(const std::string& why);
  /// No answers of the broker follow to what is published already: its connection is lost, or the topic another one.
  void expect_no_answers() { answered_ = messages_; }
  /// Answers all.
  void end(model::Outcome outcome, const std::string& why);

 private:
  void flush();
  void publish_waiting();
  void publish(std::vector<Command> batch);
  void sent(Command command);
  void sweep();
  SteadyTime next_time() const;
  void answer_message(std::vector<Command>& list, std::uint64_t message, model::Outcome outcome,
                      const std::string& why);
  void answer(const Command& command, model::Outcome outcome, std::string text);

  Scheduler& scheduler_;
  Callbacks callbacks_;
  std::vector<Command> waiting_;
  std::vector<Command> published_, echoless_;  ///< that wait for an echo; for an answer of the broker
  std::uint64_t messages_ = 0, answered_ = 0;  ///< set messages so far; those of them that the broker answered
  SteadyTime hold_until_{};
  base::OncePerTurn turn_;
  base::Deadline deadline_;
};

/// Appends a JSON string: keys come from definitions and may need escapes.
void append_key(std::string& json, std::string_view key);

}  // namespace rubicon::networks::zigbee::device
