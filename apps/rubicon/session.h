#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "apps/rubicon/exit_codes.h"
#include "apps/rubicon/output.h"
#include "apps/rubicon/settings.h"
#include "apps/rubicon/table.h"
#include "rubicon/client.hpp"

namespace rubicon::cli {

/// One run of a command: the client, standard output, and what ends it early. One a process.
class Session {
 public:
  /// nullptr: why not was said on standard error.
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

  /// Waits for others, a second for the first one.
  void discover();
  /// All that match and are there; meets first.
  std::vector<client::Tuple> read(const Pattern& pattern);

  /// `70001 (rubicon set)`; the number alone of one that is not there, or says nothing of itself.
  std::string who(OwnerId id) const;

  /// Runs the loop until `done`, the end of the patience, SIGINT or SIGTERM, or nobody reads our output; flushes it
  /// after each turn. True: done.
  bool run(const std::function<bool()>& done, Duration patience = Duration::max());
  /// By a signal, since run() began for the first time. Before, signals end the program as usual.
  bool interrupted() const;

  /// Says that there is no such thing, where it was looked for, and what to try (`hint`, if it is not empty);
  /// kNotThere.
  int nothing(const std::string& what, const std::string& hint = {});
  /// Writes what is left; kGood, or kFailed when the output cannot be written.
  int end(int code = kGood);

 private:
  explicit Session(const Settings& settings) : settings_(settings), out_(1) {}

  Settings settings_;
  Output out_;
  std::unique_ptr<Client> client_;
  bool met_ = false;
};

}  // namespace rubicon::cli
