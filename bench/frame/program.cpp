#include "frame/program.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sched.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>

namespace rubicon::bench {

bool Request::wants(const std::string& measurement) const {
  return only.empty() || std::find(only.begin(), only.end(), measurement) != only.end();
}

std::optional<int> read_request(int argc, char** argv, const ProgramText& text, const std::vector<std::string>& names,
                                Request& request) {
  CLI::App app(text.purpose, text.name);
  app.add_flag("--quick", request.quick, "a short run that checks the measurements without meaningful figures");
  app.add_option("--only", request.only, fmt::format("{} (may be repeated)", fmt::join(names, ", ")))
      ->check(CLI::IsMember(names))
      ->allow_extra_args(false);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  }
  if (!request.quick && refuses_to_measure(text.name)) return 2;
  std::signal(SIGPIPE, SIG_IGN);
  if (::geteuid() != 0) ::unshare(CLONE_NEWUSER);
  return std::nullopt;
}

bool refuses_to_measure(const char* program) {
  if (RUBICON_OPTIMISED) return false;
  fmt::print(stderr,
             "{}: this build is not optimised (-O2), so its figures would say nothing; measure with the preset "
             "`install`: cmake --preset install && cmake --build --preset install --target {}\n",
             program, program);
  return true;
}

void print_figures(const Json& figures) {
  fmt::print("{}\n", figures.dump(2));
}

}  // namespace rubicon::bench
