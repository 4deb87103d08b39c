#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <set>

#include "base/scheduler.h"
#include "networks/knx/line/line.h"

namespace rubicon::networks::knx {

/// Asks the bus for values, a few at a time and those that somebody waits for beside the others (knx.md, section 8): an
/// answer is any response or write of that address, from whomever. After 2 s without one it asks once more, then it is
/// told.
class GroupReads {
 public:
  struct Options {
    std::size_t open = 2;    ///< questions at a time
    std::size_t urgent = 4;  ///< that somebody waits for, beside those
    Duration patience = std::chrono::seconds(2);
  };
  using NoAnswer = std::function<void(GroupAddress)>;

  GroupReads(Scheduler& scheduler, Options options, NoAnswer no_answer);

  /// Questions go over this line from now on; nullptr: they wait.
  void use(Line* line);
  /// Each address is asked once, however often it is wished before the answer; `first` goes before those that are not.
  void ask(GroupAddress address, bool first);
  /// A response or write was heard.
  void heard(GroupAddress address);
  /// Nothing more is asked.
  void clear();

  std::size_t waiting() const { return urgent_.size() + others_.size() + open_.size(); }
  std::uint64_t asked() const { return asked_; }
  std::uint64_t unanswered() const { return unanswered_; }

 private:
  struct Question {
    bool first = false;
    unsigned tries = 0;
    bool under_way = false;  ///< the line has it and did not say yet that it left
    Timer patience;
  };
  void fill();
  std::size_t open(bool first) const;
  void put(GroupAddress address);
  void left(GroupAddress address);
  void over(GroupAddress address);

  Scheduler& scheduler_;
  Options options_;
  NoAnswer no_answer_;
  Line* line_ = nullptr;
  std::deque<GroupAddress> urgent_, others_;
  std::set<GroupAddress> queued_;
  std::map<GroupAddress, Question> open_;
  std::uint64_t asked_ = 0, unanswered_ = 0;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
};

}  // namespace rubicon::networks::knx
