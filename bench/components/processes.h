#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "components/node.h"

namespace rubicon::bench {

/// A program that this one started; it ends with this one at the latest.
class Child {
 public:
  Child(const std::vector<std::string>& command, const std::vector<std::string>& more_environment);
  Child(Child&& other) noexcept;
  Child& operator=(Child&&) = delete;
  ~Child();

  /// Its standard output until its end. Ends this process with a message if that takes longer than `most`, or if it
  /// fails.
  std::string output(base::Duration most);
  void signal(int number) const;
  pid_t pid() const { return pid_; }

 private:
  std::string command_;
  pid_t pid_ = -1;
  int out_ = -1;
};

/// What a process does in a measurement; returns its results as JSON.
using Role = Json (*)(const Meeting& meeting, const Json& options);

/// Starts this program in that role; `prefix` is put before the command.
Child start_role(const std::string& role, const Meeting& meeting, const Json& options,
                 const std::vector<std::string>& prefix = {});
/// Its results.
Json result_of(Child& child);

}  // namespace rubicon::bench
