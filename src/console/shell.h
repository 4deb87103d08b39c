#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/lifetime.h"
#include "tuples/meta_tuple.h"

namespace rubicon::console {

/// The line interface of `run --shell`: an ordinary component that reads command lines and writes JSON lines; no I/O of
/// its own. Answers come in the order of the commands, each with "ok"; events of subscriptions come between them. The
/// commands are in docs/shell.md.
class Shell {
 public:
  using Write = std::function<void(std::string line)>;

  /// `space` is the shell's own component, `prefix` the first key part of the island's tuples.
  Shell(TupleSpace& space, OwnerId island, std::string prefix, Write answer, Write event, std::function<void()> quit);
  ~Shell();

  /// What `reload` does: reads the configuration again, or says what that would change. The one thing here that no
  /// other component can do.
  using Reload = std::function<Result<std::vector<std::string>>(bool try_only)>;
  void on_reload(Reload reload) { reload_ = std::move(reload); }

  /// One line without its end. Never fails: bad lines are answered with an error.
  void line(std::string_view text);
  /// A line that was cut because it was longer than kMaxLine.
  void line_too_long();
  /// Calls once no answer is outstanding (at once if none is).
  void when_idle(std::function<void()> call);

  static constexpr std::size_t kMaxLine = 64UL * 1024;

 private:
  using Words = std::vector<std::string_view>;
  /// One command's answer lines; kept until all earlier commands are answered.
  struct Answer {
    std::vector<std::string> lines;
    bool done = false;
    std::vector<tuples::Handle> waits{};  ///< what brings the answer
  };
  using Slot = std::shared_ptr<Answer>;
  struct Command {
    const char* usage;
    void (Shell::*run)(std::string_view rest, const Slot& slot);
  };
  static const std::map<std::string_view, Command>& commands();

  void set(std::string_view rest, const Slot& slot);
  void append(std::string_view rest, const Slot& slot);
  void link(std::string_view rest, const Slot& slot);
  void unlink(std::string_view rest, const Slot& slot);
  void get(std::string_view rest, const Slot& slot);
  void answer_get(const tuples::TupleName& name, const Slot& slot);
  void fetch(const tuples::TupleName& name, const Slot& slot);
  void list(std::string_view rest, const Slot& slot);
  void subscribe(std::string_view rest, const Slot& slot);
  void unsubscribe(std::string_view rest, const Slot& slot);
  void devices(std::string_view rest, const Slot& slot);
  void stats(std::string_view rest, const Slot& slot);
  void post(std::string_view rest, const Slot& slot);
  void help(std::string_view rest, const Slot& slot);
  void inbox(std::string_view rest, const Slot& slot);
  void approve(std::string_view rest, const Slot& slot);
  void ignore(std::string_view rest, const Slot& slot);
  void decide(std::string_view word, std::string_view rest, const Slot& slot);
  void reload(std::string_view rest, const Slot& slot);
  void quit(std::string_view rest, const Slot& slot);

  void remote_set(OwnerId owner, const std::string& key, std::string_view value, std::string_view media_type,
                  const Slot& slot);
  /// `KEY[@SEQ] VALUE` behind `set` or `append`.
  void write(bool append, std::string_view rest, const Slot& slot);
  tuples::ReplyCall reply_to(const Slot& slot, OwnerId owner, std::string key);
  /// `[->][OWNER:]KEY`; behind an arrow, the tuple that the meta tuple leads to now.
  Result<tuples::TupleName> place(std::string_view word) const;
  Result<tuples::TupleName> link_called(std::string_view word) const;
  tuples::Handle follow(std::string_view name, const tuples::TupleName& meta, const tuples::Flow& flow);
  void finish(const Slot& slot, std::string last_line);
  void fail_with(const Slot& slot, ErrorCode code, std::string text);
  void flush();

  TupleSpace& space_;
  OwnerId island_;
  std::string prefix_;
  Write answer_, event_;
  std::function<void()> quit_, idle_;
  Reload reload_;
  bool quitting_ = false;
  std::deque<Slot> slots_;
  std::map<std::string, tuples::Handle> subscriptions_;
  tuples::Handle everything_;  ///< passive: what get, ls, devices and stats answer from
  base::Lifetime lifetime_;
};

}  // namespace rubicon::console
