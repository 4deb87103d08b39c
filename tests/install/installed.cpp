#include "install/installed.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

namespace rubicon::install {

namespace fs = std::filesystem;

const Installed& Installed::get() {
  static const Installed one;
  return one;
}

Installed::Installed()
    : root_(fs::path(testing::TempDir()) / ("rubicon_install_" + std::to_string(::getpid()))),
      prefix_(root_ / "prefix"),
      workshop_(root_ / "workshop") {
  fs::remove_all(root_);
  fs::create_directories(workshop_);
  outcome_ =
      support::run_to_end({RUBICON_CMAKE, "--install", RUBICON_BINARY_DIR, "--prefix", prefix_.string(), "--strip"});
}

Installed::~Installed() {
  std::error_code ignored;
  fs::remove_all(root_, ignored);
}

Outcome Installed::shell(const std::string& line) const {
  return support::run_to_end({"env", "LD_LIBRARY_PATH=" + (prefix_ / "lib").string(),
                              "PKG_CONFIG_PATH=" + (prefix_ / "lib/pkgconfig").string(), "sh", "-ec",
                              "exec 2>&1; " + line});
}

std::string read_text(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write_text(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << text;
}

std::string sample_island(int id) {
  return "island: {id: " + std::to_string(id) +
         ", name: home}\ntuples: {engine: dds, lease: 1s}\nnetworks:\n"
         "  dummy-1: {type: dummy, simulate: {hall: {name: Hall, sensors: {temperature-1: {wave: sine, low: 10, high: "
         "30, "
         "period: 5s}}, actuators: {lamp-1: {behaviour: obey, delay: 20ms}}}}}\n";
}

}  // namespace rubicon::install
