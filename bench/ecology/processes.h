#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "ecology/node.h"

namespace rubicon::bench {

/// A program this one started; ended with it at the latest.
class Child {
 public:
  Child(const std::vector<std::string>& command, const std::vector<std::string>& more_environment);
  Child(Child&& other) noexcept;
  Child& operator=(Child&&) = delete;
  ~Child();

  /// What it writes to its standard output until its end. Ends this process with a message when that takes longer
  /// than `most`, or it fails.
  std::string output(base::Duration most);

 private:
  std::string command_;
  pid_t pid_ = -1;
  int out_ = -1;
};

/// What a process of ours does in a measurement: the measured, in JSON.
using Role = Json (*)(const Meeting& meeting, const Json& options);

/// This program again, in that role; `prefix` stands before the command.
Child start_role(const std::string& role, const Meeting& meeting, const Json& options,
                 const std::vector<std::string>& prefix = {});
/// What it measured.
Json result_of(Child& child);

}  // namespace rubicon::bench
