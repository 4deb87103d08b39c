#pragma once

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <ostream>
#include <string>
#include <vector>

#include "support/process.h"

namespace rubicon {

struct Measurement {
  std::string name;
  std::vector<std::string> figures;  ///< what it measures
  std::vector<std::string> faults;   ///< what must be 0 however busy the machine is
};

inline std::ostream& operator<<(std::ostream& out, const Measurement& measurement) {
  return out << measurement.name;
}

/// A run that checks a measurement, and takes seconds: it measures all, and loses nothing. Skips where the program
/// skips. `quiet`: what keeps it from telling its progress.
inline void short_run(const std::string& program, const Measurement& measurement,
                      const std::vector<std::string>& quiet = {"--json"}) {
  std::vector<std::string> words{RUBICON_BINARY_DIR "/bin/" + program, "--quick", "--only", measurement.name};
  words.insert(words.end(), quiet.begin(), quiet.end());
  const auto run = support::run_to_end(words);
  ASSERT_EQ(run.code, 0) << run.errors;
  const auto out = nlohmann::json::parse(run.output);
  for (const auto& [name, value] : out.items()) {
    if (name.ends_with("_skipped")) GTEST_SKIP() << value;
  }
  for (const auto& figure : measurement.figures)
    EXPECT_TRUE(out.contains(figure) && !out.at(figure).is_null()) << figure;
  for (const auto& fault : measurement.faults) EXPECT_EQ(out.value(fault, -1), 0) << fault;
}

}  // namespace rubicon
