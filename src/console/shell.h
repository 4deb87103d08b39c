#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/scheduler.h"
#include "tuples/meta_tuple.h"
#include "verbs/answers.h"
#include "verbs/requests.h"

namespace rubicon::console {

/// The first word; `rest` loses it and the blanks around it.
std::string_view take_word(std::string_view& rest);

/// In front of a key: not this tuple, but the one its reference leads to.
inline constexpr std::string_view kArrow = "->";

/// The line interface of `run --shell`: an ordinary component that reads requests, a line each, and writes JSON lines;
/// no I/O of its own. A line is a request of docs/api.md, or words, which docs/shell.md lists; words that mean such a
/// request become it first. Answers come in the order of the lines, each with "ok"; events of subscriptions come
/// between them.
class Shell {
 public:
  using Write = std::function<void(std::string line)>;

  /// `space` is the shell's own component, `prefix` the first key part of the island's tuples.
  Shell(Scheduler& scheduler, TupleSpace& space, OwnerId island, std::string prefix, Write answer, Write event,
        std::function<void()> quit);
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
  using Members = verbs::Members;
  /// One command's answer lines; kept until all earlier commands are answered.
  struct Answer {
    verbs::Line begin = verbs::Line::object();  ///< of the last line: the id of the request, if it has one
    std::vector<std::string> lines{};
    bool done = false;
    std::vector<tuples::Handle> waits{};  ///< what brings the answer
  };
  struct Subscribed {
    std::string name;  ///< the pattern, as it was given
    tuples::Handle handle;
  };
  using Slot = std::shared_ptr<Answer>;
  struct Command {
    const char* usage;
    void (Shell::*run)(std::string_view word, std::string_view rest, const Slot& slot);
  };
  static const std::map<std::string_view, Command>& commands();

  // -- requests of docs/api.md
  void request(std::string_view line, const Slot& slot);
  void run(std::string_view verb, Members& members, const Slot& slot);
  /// Puts the key in the place of what people call a tuple of the island.
  Result<void> resolve(std::string_view verb, Members& members) const;
  void get(const Pattern& tuple, const Slot& slot);
  void fetch(const Pattern& tuple, const Slot& slot);
  void answer_get(const Pattern& tuple, const Slot& slot);
  /// `name`: as it was typed; it replaces the subscription of that name, and may begin with an arrow.
  void subscribe(Members& members, const Slot& slot, std::string_view name = {});

  // -- words that become such requests; `word` is the first one, `rest` what follows it
  void write(std::string_view word, std::string_view rest, const Slot& slot);
  void get_word(std::string_view word, std::string_view rest, const Slot& slot);
  void subscribe_word(std::string_view word, std::string_view rest, const Slot& slot);
  void unsubscribe_word(std::string_view word, std::string_view rest, const Slot& slot);
  /// The member `key` of `[->][OWNER:]KEY`; behind an arrow, the tuple that the meta tuple leads to now.
  Result<std::string> place(std::string_view text) const;

  // -- words of the shell alone
  void link(std::string_view word, std::string_view rest, const Slot& slot);
  void unlink(std::string_view word, std::string_view rest, const Slot& slot);
  void list(std::string_view word, std::string_view rest, const Slot& slot);
  void devices(std::string_view word, std::string_view rest, const Slot& slot);
  void stats(std::string_view word, std::string_view rest, const Slot& slot);
  void post(std::string_view word, std::string_view rest, const Slot& slot);
  void help(std::string_view word, std::string_view rest, const Slot& slot);
  void inbox(std::string_view word, std::string_view rest, const Slot& slot);
  void decide(std::string_view word, std::string_view rest, const Slot& slot);
  void reload(std::string_view word, std::string_view rest, const Slot& slot);
  void quit(std::string_view word, std::string_view rest, const Slot& slot);

  void send(const verbs::Set& set, const Slot& slot);
  tuples::ReplyCall reply_to(const Slot& slot, OwnerId owner, std::string key);
  Result<tuples::TupleName> link_called(std::string_view word) const;
  tuples::Handle follow(std::string_view name, const tuples::TupleName& meta, const tuples::Flow& flow);
  void finish(const Slot& slot, const verbs::Line& content = verbs::Line::object(), const Result<void>& done = {});
  void fail_with(const Slot& slot, Error error);
  void flush();

  Scheduler& scheduler_;
  TupleSpace& space_;
  OwnerId island_;
  std::string prefix_;
  Write answer_, event_;
  std::function<void()> quit_, idle_;
  Reload reload_;
  bool quitting_ = false;
  std::deque<Slot> slots_;
  std::map<unsigned, Subscribed> subscriptions_;
  unsigned last_subscription_ = 0;
  tuples::Handle everything_;  ///< passive: what get, ls, devices and stats answer from
  base::Lifetime lifetime_;
};

}  // namespace rubicon::console
