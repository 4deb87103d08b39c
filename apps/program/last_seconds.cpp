#include "apps/program/last_seconds.h"

#include <unistd.h>

#include <csignal>

namespace rubicon::program {

namespace {

constexpr unsigned kSeconds = 2;
volatile std::sig_atomic_t exit_code = 0;

}  // namespace

void end_within_seconds(int code) {
  exit_code = code;
  struct sigaction action {};
  action.sa_handler = [](int) { ::_exit(exit_code); };
  ::sigaction(SIGALRM, &action, nullptr);
  ::alarm(kSeconds);
}

void end_whenever_done() {
  ::alarm(0);
}

}  // namespace rubicon::program
