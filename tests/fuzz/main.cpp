#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "fuzz_target.h"

namespace rubicon::fuzz {

namespace {

std::vector<const Target*>& targets() {
  static std::vector<const Target*> all;
  return all;
}

const Target* running = nullptr;

}  // namespace

Target::Target(std::string_view name_of_target, Run run_one, void (*prepare_it)())
    : name(name_of_target), run(run_one), prepare(prepare_it) {
  targets().push_back(this);
}

const Target* chosen() {
  return running;
}

namespace {

/// Ends the process with the names there are if the program has the name of none.
void choose(std::string_view program) {
  program.remove_prefix(program.rfind('/') + 1);
  for (const auto* one : targets()) {
    if (std::string(one->name) + "_fuzz" == program) running = one;
  }
  if (running) return;
  std::fprintf(stderr,
               "%s: no target has this name; start one of the links to this program: NAME_fuzz with NAME one of\n",
               std::string(program).c_str());
  for (const auto* one : targets()) std::fprintf(stderr, "%s\n", std::string(one->name).c_str());
  std::exit(2);
}

}  // namespace

}  // namespace rubicon::fuzz

extern "C" int LLVMFuzzerInitialize(int*, char*** argv) {
  rubicon::fuzz::choose((*argv)[0]);
  const auto* target = rubicon::fuzz::chosen();
  if (target->prepare) target->prepare();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return rubicon::fuzz::chosen()->run(data, size);
}
