#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <functional>

namespace rubicon::state {

/// Does something that ends or changes a process in one of its own; the answer is what `body` returns, -1 if it did not
/// get that far.
inline int run_child(const std::function<int()>& body) {
  std::fflush(nullptr);
  const auto child = ::fork();
  if (child == 0) ::_exit(body());
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// In a child: says what was not true.
inline bool holds(bool condition, const char* what) {
  if (!condition) std::fprintf(stderr, "child: not true: %s\n", what);
  return condition;
}

}  // namespace rubicon::state
