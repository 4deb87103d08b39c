#pragma once

#include <array>
#include <deque>
#include <functional>
#include <map>
#include <memory>

#include "base/scheduler.h"
#include "networks/knx/line/line.h"

namespace rubicon::networks::knx {

/// Asks the bus for values, a few at a time (knx.md, section 8): an answer is any response or write of that address,
/// from whomever. After 2 s without one it asks once more, then it is told.
class GroupReads {
 public:
  /// Who asks. Each has questions of its own open, so that none waits for another's that nobody answers.
  enum class Rank : std::uint8_t { kVerify, kWanted, kAgain, kMarked };
  static constexpr std::size_t kRanks = 4;

  struct Options {
    std::array<std::size_t, kRanks> open{2, 4, 2, 2};  ///< questions at a time, by rank
    Duration patience = std::chrono::seconds(2);
  };
  using NoAnswer = std::function<void(wire::GroupAddress)>;

  GroupReads(Scheduler& scheduler, Options options, NoAnswer no_answer);

  /// Questions go over this line from now on; nullptr: they wait.
  void use(line::Line* line);
  /// Each address is asked once, however often it is wished before the answer; in the best rank it was wished in.
  void ask(wire::GroupAddress address, Rank rank);
  /// A response or write was heard.
  void heard(wire::GroupAddress address);
  /// Only these are asked any more.
  void keep(const std::function<bool(wire::GroupAddress)>& wanted);

  std::size_t waiting() const { return ranks_.size() + open_.size(); }
  std::uint64_t asked() const { return asked_; }
  std::uint64_t unanswered() const { return unanswered_; }

 private:
  struct Question {
    Rank rank = Rank::kMarked;
    unsigned tries = 0;
    bool under_way = false;  ///< the line has it and did not say yet that it left
    Timer patience;
  };
  void fill();
  void put(wire::GroupAddress address);
  void left(wire::GroupAddress address);
  void over(wire::GroupAddress address);

  Scheduler& scheduler_;
  Options options_;
  NoAnswer no_answer_;
  line::Line* line_ = nullptr;
  std::array<std::deque<wire::GroupAddress>, kRanks>
      queues_;                                ///< what left ranks_, or has a better rank there, is passed over
  std::map<wire::GroupAddress, Rank> ranks_;  ///< of those that wait
  std::map<wire::GroupAddress, Question> open_;
  std::array<std::size_t, kRanks> open_count_{};
  std::uint64_t asked_ = 0, unanswered_ = 0;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
};

}  // namespace rubicon::networks::knx
