#include "examples/judgement.h"

#include <algorithm>
#include <array>
#include <sstream>

namespace rubicon::examples {

namespace {

/// Ends with another code than 0, which the page of exit codes names.
struct Code {
  const char* part;
  int code;
  const char* why;
};
constexpr Code kCodes[] = {
    {"doctor --interfaces eth0", 1, "there is no such interface here: that is the problem it finds"},
    {"--engine peis watch", 0, "it waits for kernels, of which none is on the network of this test"},
    {"--engine peis doctor", 1, "the demo is not on PEIS, and no kernel is: that is the problem it finds"},
    {"--engine peis", 8, "no kernel is on the network of this test, which the answer says"},
    {"networks knx-demo reopen", 3, "the line of the demo is up, which the answer says"},
    {"send 6541 --type image", 3, "nobody on the demo's island waits for images, which the answer says"},
};

bool has(const std::string& text, const char* part) {
  return text.find(part) != text.npos;
}

template <std::size_t kCount>
bool begins(const std::string& line, const std::array<const char*, kCount>& programs) {
  return std::any_of(programs.begin(), programs.end(), [&](const char* one) { return line.starts_with(one); });
}

int wanted_code(const std::string& line) {
  for (const auto& one : kCodes) {
    if (has(line, one.part)) return one.code;
  }
  return 0;
}

/// Messages to nobody, of examples before it, are losses that the doctor names: any other problem is a fault.
bool found_losses_only(const std::string& output) {
  std::istringstream lines(output);
  std::size_t losses = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("problem ") && !has(line, R"("grade":"problem")")) continue;
    if (!line.starts_with("problem  loss ") && !line.starts_with(R"({"check":"loss",)")) return false;
    ++losses;
  }
  return losses > 0;
}

}  // namespace

bool shows_what_is_there(const std::string& line) {
  return begins(line, std::array{"rubicon watch", "rubicon top", "rubicon knx monitor", "rubicon wsn monitor",
                                 "rubicon zigbee monitor", "example-4_points", "curl"});
}

bool is_endless(const std::string& line) {
  if (begins(line, std::array{"rubicon recorder"}) || has(line, " --for 0s")) return false;
  if (begins(line, std::array{"rubicon --engine peis watch", "rubicon zigbee permit"})) return true;
  constexpr std::array kPrograms{"rubicon record",       "rubicon receive",   "rubicon publish",
                                 "rubicon log --follow", "rubicon-proxy run", "rubicon web",
                                 "rubicon mqtt",         "rubicon ros2",      "motes-simulator --port",
                                 "salad-simulator ",     "knx-simulator ",    "zigbee-simulator "};
  if (begins(line, std::array{"curl"})) return has(line, "text/event-stream");
  return (shows_what_is_there(line) || begins(line, kPrograms)) && !has(line, " | ") && !has(line, " --rounds ");
}

std::string fault_of(const std::string& line, const support::Outcome& outcome) {
  constexpr int kNotGood = 10;       // `get` of a sensor that is not sampled at the moment
  constexpr int kInterrupted = 130;  // the shell around a program that runs until it is ended
  if (line.starts_with("rubicon get ") && outcome.code == kNotGood)
    return has(outcome.errors, " is ") ? "" : "does not say why its value is not good";
  if (line.starts_with("rubicon doctor") && outcome.code == 1 && found_losses_only(outcome.output)) return "";
  const bool ended = is_endless(line) && outcome.code == kInterrupted;
  if (!ended && outcome.code != wanted_code(line)) return "ended with " + std::to_string(outcome.code);
  if (shows_what_is_there(line) && outcome.output.empty()) return "shows nothing";
  if (shows_what_is_there(line) && has(outcome.errors, "nothing fits")) return "names what is not there";
  return "";
}

}  // namespace rubicon::examples
