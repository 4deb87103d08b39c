#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/rubicon/output/output.h"
#include "apps/rubicon/output/table.h"
#include "apps/rubicon/settings.h"
#include "rubicon/client.hpp"

namespace rubicon::cli {

/// The outcome of a command that is not waited for any longer.
inline const client::Outcome kEndedBySignal{"timed-out", "ended by a signal", 0, {}};

/// One run of a command: the client, standard output, and signals that end it early. One per process.
class Session {
 public:
  /// nullptr after the reason was printed on standard error.
  static std::unique_ptr<Session> open(const Settings& settings, std::string_view command);

  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  Client& client() { return *client_; }
  Output& out() { return out_; }
  const Settings& settings() const { return settings_; }
  bool json() const { return settings_.json; }
  Look look() const { return {out_.has_colour(), out_.width()}; }
  WallTime now() const;

  /// Discovers the components that are present; waits at most a second for the first one, on PEIS 3 s.
  void discover();
  /// All present tuples that match. Discovers the owners first, unless the pattern names one.
  std::vector<client::Tuple> read(const Pattern& pattern);

  /// What is left of the patience for a component that is named, since the beginning.
  Duration patience_left() const {
    return std::max<Duration>(settings_.patience - (std::chrono::steady_clock::now() - opened_), Duration(0));
  }

  /// `70001 (rubicon set)`; only the id of a component that is absent or has no summary.
  std::string component_text(OwnerId id) const;

  /// Runs the loop until `done`, the end of `patience`, SIGINT, SIGTERM, or until the reader of our output closes it.
  /// Flushes the output after each turn. True: done.
  bool run(const std::function<bool()>& done, Duration patience = Duration::max());
  /// Waits for work of the loop or for something to read from the descriptor, and does the work. Whether there is
  /// something to read, or the other end is gone.
  bool turn(int descriptor);
  /// From now on a signal ends run() and turn(), not the program.
  void catch_signals();
  /// As Client::command(), but a signal ends it: timed-out.
  client::Outcome command(OwnerId owner, std::string_view key, std::string_view value);
  /// Whether a signal came since the first run(). Before that, signals end the program as usual.
  bool interrupted() const;
  /// After an interrupt: run() waits again, until the next signal.
  void resume();

  /// Prints that something was not found, where the program looked, and what to try (`hint`, unless empty). Returns
  /// kNotThere.
  int not_found(const std::string& what, const std::string& hint = {});
  /// Writes the rest of the output. `code`; kFailed in place of kGood when it cannot be written.
  int end(int code = kGood);

 private:
  explicit Session(const Settings& settings) : settings_(settings), out_(1) {}

  Settings settings_;
  Output out_;
  std::unique_ptr<Client> client_;
  bool discovered_ = false;
  const SteadyTime opened_ = std::chrono::steady_clock::now();
};

}  // namespace rubicon::cli
