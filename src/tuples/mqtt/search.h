#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "tuples/mqtt/topics.h"

namespace rubicon::tuples::mqtt {

/// Reads the presence of the components that this process deals with, or of all. A broker sends retained messages at
/// once after a subscription. A message to the own inbox marks their end: each step subscribes to some filters and then
/// waits for that message. So thousands of islands can meet at a broker without each of them reading of all others.
/// Without I/O.
class Search {
 public:
  struct Callbacks {
    std::function<void(const std::string&filter)> subscribe, unsubscribe;
    /// Sends a message to oneself, which brings this number back to passed().
    std::function<void(std::uint64_t step)> fence;
    /// That message did not come within kFenceTime and is sent again.
    std::function<void()> late;
    /// All retained messages of a connection have come.
    std::function<void(const Line& line)> line_read;
    /// Everything that is looked for was read since connected() or read_again(); `all`: and that is all presence.
    std::function<void(bool all)> complete;
  };
  static constexpr Duration kFenceTime = std::chrono::seconds(10);
  /// Components that are searched for one by one; if more are kept, all presence is read.
  static constexpr std::size_t kMaxSought = 4096;
  /// Connections, and connections of one user that are not read yet. Further ones are ignored.
  static constexpr std::size_t kMaxLines = 16'384, kMaxUnread = 256;

  Search(const Topics& topics, Scheduler& scheduler, Callbacks calls);

  /// Everything is read from its beginning.
  void connected();
  void cut();
  /// Where it is idle.
  void read_again();
  void passed(std::uint64_t step);

  /// Looks for all, from now on.
  void all();
  /// Looks for a component that a request names; it is forgotten first when there are too many.
  void component(OwnerId id);
  /// Looks for it until drop() was called as often, and forget() after that.
  void keep(OwnerId id);
  void drop(OwnerId id);
  void forget(OwnerId id);
  /// Somebody who spoke to this process, or who has a component that is looked for. True: it will be read by itself.
  bool line(const Line& line);
  void forget(const Line& line);

  /// Whether what is shown there is looked for.
  bool wants(const Line& line, std::optional<OwnerId> id) const;
  bool knows_all() const { return all_ && all_read_; }
  /// Whether a component that is not present was not there when it was looked for, or last.
  bool knows(OwnerId id) const;
  /// Whether everything was read on this connection.
  bool ready() const { return ready_; }
  /// Nothing is being read.
  bool idle() const { return queue_.empty() && step_.empty(); }

 private:
  struct Part {
    std::string filter;  ///< empty: only the message to oneself
    std::optional<OwnerId> component{};
    std::optional<Line> line{};
    bool alone = false;     ///< a step of its own
    bool ends = false;      ///< no step: what was read is complete
    bool ends_all = false;  ///< and was all presence
  };
  struct Sought {
    bool read = false;
    bool dropped = false;     ///< by all who kept it
    std::uint32_t needs = 0;  ///< calls of keep() without a drop()
  };
  static constexpr std::size_t kMaxParts = 100;  ///< of a step

  void add_all();
  void next();
  void fence();
  void read(const Line& line);
  void narrow();
  void make_room();
  void cancel(const std::string& filter);
  void count_read(const Line& line);

  const Topics& topics_;
  Callbacks callbacks_;
  bool connected_ = false, all_ = false, all_read_ = false, ready_ = false;
  std::map<OwnerId, Sought> components_;
  std::map<Line, bool> lines_;                 ///< whether it was read
  std::map<std::string, std::size_t> unread_;  ///< of lines_, by user
  std::deque<Part> queue_;
  std::vector<Part> step_;  ///< that is under way
  std::uint64_t number_ = 0;
  base::Deadline late_;
};

}  // namespace rubicon::tuples::mqtt
