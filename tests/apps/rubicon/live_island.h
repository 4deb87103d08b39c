#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "support/private_network.h"
#include "support/process.h"

namespace rubicon::cli {

inline const std::string kProgram = RUBICON_BINARY_DIR "/bin/rubicon";
inline const std::string kDaemon = RUBICON_BINARY_DIR "/bin/rubicon-proxy";

using support::Outcome;
using support::PrivateNetwork;
using support::Process;

/// Runs `rubicon` to its end.
inline Outcome rubicon(std::vector<std::string> arguments, const std::string& input = {}) {
  arguments.insert(arguments.begin(), kProgram);
  return support::run_to_end(std::move(arguments), input);
}

/// What a shell is offered, however slow the machine is.
inline Outcome completed(std::vector<std::string> words) {
  words.insert(words.begin(), {"--patience", "30s", "complete", "--"});
  return rubicon(std::move(words));
}

/// Each line of the output as JSON; what is none becomes a discarded value.
inline std::vector<nlohmann::json> lines_of(const Outcome& outcome) {
  std::vector<nlohmann::json> lines;
  std::istringstream text(outcome.output);
  for (std::string line; std::getline(text, line);) lines.push_back(nlohmann::json::parse(line, nullptr, false));
  return lines;
}

/// A folder of this test program alone, removed at the end.
class Folder {
 public:
  Folder() : path_(std::filesystem::temp_directory_path() / ("rubicon_cli_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string file(const std::string& name) const { return (path_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(file(name), std::ios::binary) << text;
    return file(name);
  }

 private:
  std::filesystem::path path_;
};

/// A small island with one sensor, for those who need no more.
inline std::string small_island(int id, const std::string& tuples = "{}") {
  return "island: {id: " + std::to_string(id) + ", name: small}\ntuples: " + tuples +
         "\nnetworks:\n  dummy-1: {type: dummy, simulate: {den: {sensors: {temperature-1: {}}}}}\n";
}

/// A daemon that is ready when it is constructed: its shell answered.
inline std::unique_ptr<Process> started(const std::string& file, std::vector<std::string> more = {}) {
  std::vector<std::string> arguments{kDaemon, "run", file, "--shell", "--log-level", "error"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  auto island = std::make_unique<Process>(std::move(arguments));
  island->write("stats\n");
  std::ignore = island->line_with("\"ok\"");
  return island;
}

}  // namespace rubicon::cli
