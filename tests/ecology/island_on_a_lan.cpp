#include "ecology/island_on_a_lan.h"

#include <chrono>
#include <fstream>
#include <thread>
#include <tuple>

namespace rubicon::ecology {

namespace fs = std::filesystem;

void IslandOnALan::SetUp() {
  if (!lan_.made()) GTEST_SKIP() << lan_.reason();
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  folder_ = fs::path(testing::TempDir()) / ("rubicon_lan_" + std::string(test->name()));
  fs::remove_all(folder_);
  fs::create_directories(folder_);
}

void IslandOnALan::TearDown() {
  island_.reset();
  if (!folder_.empty()) fs::remove_all(folder_);
}

void IslandOnALan::write(const std::string& name, const std::string& text) const {
  std::ofstream(file(name), std::ios::binary) << text;
}

void IslandOnALan::configure(const std::string& tuples, const std::string& more) const {
  write("home.yaml", "island: {id: 1, name: home}\ntuples: " + tuples +
                         "\nnetworks:\n"
                         "  dummy-1: {type: dummy, simulate: {den: {actuators: {switch-1: {}, switch-2: {}}}}}\n" +
                         more);
}

support::Outcome IslandOnALan::other(std::vector<std::string> words) const {
  const Host::Visit visit(lan_.host(1));
  words.insert(words.begin(), kToolProgram);
  words.insert(words.end(), {"--engine", "dds", "--interfaces", Lan::kCable});
  return support::run_to_end(std::move(words));
}

support::Outcome IslandOnALan::here(std::vector<std::string> words) const {
  const Host::Visit visit(lan_.host(0));
  words.insert(words.begin(), kToolProgram);
  return support::run_to_end(std::move(words));
}

std::unique_ptr<support::Process> IslandOnALan::start(int host, std::vector<std::string> words) const {
  const Host::Visit visit(lan_.host(host));
  return std::make_unique<Process>(std::move(words));
}

void IslandOnALan::start_island(const std::vector<std::string>& before) {
  auto words = before;
  words.insert(words.end(), {kDaemonProgram, "run", file("home.yaml"), "--shell"});
  island_ = start(0, std::move(words));
  island_->write("stats\n");
  std::ignore = island_->line_with("\"ok\"");
}

bool says(support::Process& program, const std::string& text) {
  using namespace std::chrono_literals;
  for (int i = 0; i < 6000; ++i, std::this_thread::sleep_for(10ms)) {
    if (program.errors().find(text) != std::string::npos) return true;
  }
  return false;
}

}  // namespace rubicon::ecology
