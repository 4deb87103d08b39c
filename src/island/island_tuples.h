#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "rubicon/summary.hpp"
#include "rubicon/tuple_space.hpp"

namespace rubicon::island {

/// Publishes the island's own numbers and states as `<prefix>.property.<name>.value`: queues, drops, what the state
/// file and the recorders do. Once a second, and only what changed. While a component subscribes actively to
/// `<prefix>.property.clock.value` that says what the island's clock says, so that others can compare it with theirs.
class IslandMetrics {
 public:
  /// Publishes one number or word; names are `[a-z-]+`.
  class Publish {
   public:
    explicit Publish(std::map<std::string, std::string>& into) : into_(into) {}
    void operator()(const std::string& name, std::uint64_t value) const { into_[name] = std::to_string(value); }
    void word(const std::string& name, std::string text) const { into_[name] = std::move(text); }

   private:
    std::map<std::string, std::string>& into_;
  };
  using Source = std::function<void(const Publish& publish)>;

  IslandMetrics(Scheduler& scheduler, TupleSpace& space, std::string prefix);

  /// Asked each time; what it uses must live as long as this.
  void add(Source source) { sources_.push_back(std::move(source)); }
  void start();

 private:
  void publish();
  void publish_clock();

  Scheduler& scheduler_;
  TupleSpace& space_;
  std::string prefix_;
  std::vector<Source> sources_;
  std::map<std::string, std::string> published_;
  bool clock_wanted_ = false;
  tuples::Handle clock_watch_;
  Timer timer_;
};

/// What the others see of this island without asking, and `<prefix>.islands`, its list of those it sees: both at most
/// once a second, a few times in its first one, and only what changed.
class IslandPresence {
 public:
  /// How many devices each network lists.
  using Count = std::function<std::map<std::string, std::uint64_t>()>;

  IslandPresence(Scheduler& scheduler, TupleSpace& space, std::string name, std::string prefix, Count count);

  void start();

 private:
  void refresh();
  void list_islands();
  std::string islands() const;

  Scheduler& scheduler_;
  TupleSpace& space_;
  Count count_;
  Summary summary_;
  std::string described_, listed_;
  Duration pause_{};
  Timer timer_;
};

/// A log whose last lines an island can show to other components: keeps them in bounded memory, with secrets masked
/// (base/log.h), and passes every line on unchanged.
class LogLines final : public base::LogSink {
 public:
  static constexpr std::size_t kKept = 100;
  /// Of a line, in bytes.
  static constexpr std::size_t kMaxTextCount = 2000, kMaxSubject = 100;

  struct Line {
    std::uint64_t number = 0;  ///< counts from 1, so that readers find what they missed
    WallTime time{};
    base::LogLevel level = base::LogLevel::kInfo;
    std::string subject, text;  ///< one line of printable text each
  };

  /// Lines below `least` are passed on and not kept. `behind` and `clock` must outlive this.
  LogLines(base::LogSink& behind, const base::Scheduler& clock, base::LogLevel least = base::LogLevel::kInfo)
      : behind_(behind), clock_(clock), least_(least) {}

  void write(base::LogLevel level, std::string_view who, std::string_view text) override;

  /// Called after each line that is kept; it may only ask for a later turn. Empty = no call.
  void on_line(std::function<void()> call) { call_ = std::move(call); }
  const std::deque<Line>& lines() const { return lines_; }
  /// JSON list of {number, time, level, subject, text}, the oldest first.
  std::string json() const;

 private:
  base::LogSink& behind_;
  const base::Scheduler& clock_;
  base::LogLevel least_;
  std::uint64_t written_ = 0;
  std::deque<Line> lines_;
  std::function<void()> call_;
};

/// Publishes the last lines of a log as one tuple, at most four times a second, and only while a component subscribes
/// to it. An active subscription gets the present lines at once, a passive one within a second after the next line.
class LogTuples {
 public:
  /// Everything must outlive it.
  LogTuples(Scheduler& scheduler, TupleSpace& space, std::string key, LogLines& lines);
  ~LogTuples() { lines_.on_line({}); }
  LogTuples(const LogTuples&) = delete;
  LogTuples& operator=(const LogTuples&) = delete;

 private:
  void publish_if_wanted();
  void publish();

  Scheduler& scheduler_;
  TupleSpace& space_;
  std::string key_;
  LogLines& lines_;
  base::PacedCall publish_;
  Timer look_again_;
  tuples::Handle demand_;
};

}  // namespace rubicon::island
