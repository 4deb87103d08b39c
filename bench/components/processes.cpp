#include "components/processes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <utility>

namespace rubicon::bench {

namespace {

constexpr Duration kMaxRole = std::chrono::minutes(6);

std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (auto& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

}  // namespace

Child::Child(const std::vector<std::string>& command, const std::vector<std::string>& more_environment)
    : command_(command.front()) {
  int ends[2] = {};
  if (::pipe2(ends, O_CLOEXEC) != 0) give_up("no pipe for a child");
  auto arguments = command;
  auto environment = more_environment;
  for (char** at = environ; *at; ++at) environment.emplace_back(*at);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  const auto answer = ::posix_spawnp(&pid_, command_.c_str(), &actions, nullptr, pointers_to(arguments).data(),
                                     pointers_to(environment).data());
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  out_ = ends[0];
  if (answer != 0) give_up(command_ + " cannot be started");
}

Child::Child(Child&& other) noexcept
    : command_(std::move(other.command_)), pid_(std::exchange(other.pid_, -1)), out_(std::exchange(other.out_, -1)) {}

Child::~Child() {
  if (out_ >= 0) ::close(out_);
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

std::string Child::output(Duration most) {
  const auto until = std::chrono::steady_clock::now() + most;
  std::string text;
  char piece[65536];
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
    pollfd ready{out_, POLLIN, 0};
    if (left.count() <= 0 || ::poll(&ready, 1, static_cast<int>(left.count())) == 0)
      give_up(command_ + " does not come to its end");
    const auto count = ::read(out_, piece, sizeof piece);
    if (count <= 0) break;
    text.append(piece, static_cast<std::size_t>(count));
  }
  int status = 0;
  ::waitpid(std::exchange(pid_, -1), &status, 0);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) give_up(fmt::format("{} failed, status {}", command_, status));
  return text;
}

void Child::signal(int number) const {
  ::kill(pid_, number);
}

Child start_role(const std::string& role, const Meeting& meeting, const Json& options,
                 const std::vector<std::string>& prefix) {
  auto command = prefix;
  command.insert(command.end(), {std::filesystem::read_symlink("/proc/self/exe").string(), "--role", role, "--domain",
                                 std::to_string(meeting.domain), "--tag", meeting.tag, "--trust-folder", meeting.trust,
                                 "--of-engine", meeting.engine, "--options", options.dump()});
  return {command, {}};
}

Json result_of(Child& child) {
  const auto text = child.output(kMaxRole);
  auto result = Json::parse(text, nullptr, false);
  if (result.is_discarded()) give_up("a role answered what is no JSON: " + text.substr(0, 200));
  return result;
}

}  // namespace rubicon::bench
