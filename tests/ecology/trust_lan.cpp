#include "ecology/trust_lan.h"

#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>
#include <tuple>

namespace rubicon::ecology {

namespace fs = std::filesystem;

void TrustOnALan::SetUp() {
  if (!lan_.made()) GTEST_SKIP() << lan_.reason();
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  folder_ = fs::path(testing::TempDir()) / ("rubicon_trust_" + std::string(test->name()));
  fs::remove_all(folder_);
  fs::create_directories(folder_);
  configure("");
}

void TrustOnALan::TearDown() {
  island_.reset();
  if (!folder_.empty()) fs::remove_all(folder_);
}

std::string TrustOnALan::text_in(const std::string& name) const {
  std::ostringstream text;
  text << std::ifstream(file(name), std::ios::binary).rdbuf();
  return text.str();
}

void TrustOnALan::write(const std::string& name, const std::string& text) const {
  std::ofstream(file(name), std::ios::binary) << text;
}

void TrustOnALan::configure(const std::string& more, const std::string& tuples) const {
  write("home.yaml", "island: {id: 1, name: home}\ntuples: {host: no, " + tuples +
                         ", trust: ./trust}\nnetworks:\n"
                         "  dummy-1: {type: dummy, simulate: {den: {actuators: {switch-1: {}}}}}\n" +
                         more);
}

support::Outcome TrustOnALan::on(int host, std::vector<std::string> words, const std::string& input) const {
  const Host::Visit visit(lan_.host(host));
  words.insert(words.begin(), kToolProgram);
  words.insert(words.end(), {"--engine", "dds", "--interfaces", "cable"});
  return support::run_to_end(std::move(words), input);
}

support::Outcome TrustOnALan::authority(std::vector<std::string> words) const {
  if (words.front() != "audit") words.insert(words.begin(), "dds");
  words.insert(words.begin(), "trust");
  return local(std::move(words));
}

support::Outcome TrustOnALan::local(std::vector<std::string> words) const {
  words.insert(words.end(), {"--trust", file("trust")});
  return on(0, std::move(words));
}

support::Outcome TrustOnALan::person(std::vector<std::string> words, const std::string& input) const {
  words.insert(words.end(), {"--trust", file("desk")});
  return on(1, std::move(words), input);
}

void TrustOnALan::make_realm() const {
  const auto made = authority({"init"});
  ASSERT_EQ(made.code, 0) << made.errors;
}

void TrustOnALan::add_member(const std::string& name, int host, const std::vector<std::string>& more) const {
  const auto bundle = file(name + ".trust"), phrase = file(name + ".phrase");
  std::vector<std::string> words{"add", name, "--out", bundle, "--phrase-file", phrase};
  words.insert(words.end(), more.begin(), more.end());
  const auto added = authority(words);
  ASSERT_EQ(added.code, 0) << added.errors;
  const auto joined =
      on(host, {"trust", "dds", "join", bundle, "--yes", "--phrase-file", phrase, "--trust", file(name)});
  ASSERT_EQ(joined.code, 0) << joined.errors;
}

void TrustOnALan::add_desk(const std::string& role) const {
  make_realm();
  add_member("desk", 1, {"--role", role});
}

std::unique_ptr<support::Process> TrustOnALan::start(int host, std::vector<std::string> words) const {
  const Host::Visit visit(lan_.host(host));
  return std::make_unique<Process>(std::move(words));
}

std::unique_ptr<support::Process> TrustOnALan::island_on(int host, const std::string& configuration,
                                                         const std::vector<std::string>& before) const {
  auto words = before;
  words.insert(words.end(), {kDaemonProgram, "run", file(configuration), "--shell"});
  auto island = start(host, std::move(words));
  island->write("stats\n");
  std::ignore = island->line_with("\"ok\"");
  return island;
}

support::Outcome TrustOnALan::run_island(const std::vector<std::string>& before) const {
  const Host::Visit visit(lan_.host(0));
  auto words = before;
  words.insert(words.end(), {kDaemonProgram, "run", file("home.yaml"), "--shell"});
  return support::run_to_end(std::move(words), "quit\n");
}

bool says(support::Process& program, const std::string& text, int times) {
  using namespace std::chrono_literals;
  for (int i = 0; i < 6000; ++i, std::this_thread::sleep_for(10ms)) {
    const auto errors = program.errors();
    int found = 0;
    for (auto at = errors.find(text); at != errors.npos; at = errors.find(text, at + 1)) ++found;
    if (found >= times) return true;
  }
  return false;
}

}  // namespace rubicon::ecology
