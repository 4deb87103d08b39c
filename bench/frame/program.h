#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "frame/figures.h"

namespace rubicon::bench {

/// The command line of a program that measures.
struct Request {
  bool quick = false;
  std::vector<std::string> only;  ///< empty = all

  bool wants(const std::string& measurement) const;
};

/// Name and purpose of a program, as `--help` shows them.
struct ProgramText {
  const char* name;
  const char* purpose;
};

/// Reads the command line, and makes private networks possible for a user other than root. An exit code if the program
/// has to end.
std::optional<int> read_request(int argc, char** argv, const ProgramText& text, const std::vector<std::string>& names,
                                Request& request);
void print_figures(const Json& figures);
/// Whether figures of this build would say nothing, because the preset does not optimise what is measured (-O2); then
/// says so on standard error. Callers end with exit code 2.
bool refuses_to_measure(const char* program);

/// By name; each adds its figures.
template <class Plan>
using Measurements = std::vector<std::pair<std::string, void (*)(const Plan& plan, Json& out)>>;

/// A program that makes the measurements that its command line names, by a default plan or the `quick` one, and prints
/// the figures as one JSON object. Returns the exit code.
template <class Plan>
int run_program(int argc, char** argv, const ProgramText& text, const Plan& quick, const Measurements<Plan>& all) {
  std::vector<std::string> names;
  for (const auto& one : all) names.push_back(one.first);
  Request request;
  if (const auto code = read_request(argc, argv, text, names, request)) return *code;
  Json out;
  for (const auto& [name, measure] : all) {
    if (request.wants(name)) measure(request.quick ? quick : Plan{}, out);
  }
  print_figures(out);
  return 0;
}

}  // namespace rubicon::bench
