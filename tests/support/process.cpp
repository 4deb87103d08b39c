#include "support/process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <charconv>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

namespace rubicon::support {

namespace {

using Clock = std::chrono::steady_clock;

std::array<int, 2> make_pipe() {
  std::array<int, 2> ends{-1, -1};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) ::_exit(99);
  return ends;
}

void shut(int& descriptor) {
  if (descriptor >= 0) ::close(descriptor);
  descriptor = -1;
}

/// What is there, without waiting; false at the end.
bool read_some(int descriptor, std::string& into) {
  std::array<char, 65536> buffer;
  const auto count = ::read(descriptor, buffer.data(), buffer.size());
  if (count > 0) into.append(buffer.data(), static_cast<std::size_t>(count));
  return count > 0;
}

}  // namespace

Process::Process(std::vector<std::string> arguments) {
  std::signal(SIGPIPE, SIG_IGN);
  std::vector<char*> argv;
  for (auto& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const auto in = make_pipe();
  const auto out = make_pipe();
  const auto err = make_pipe();
  const auto test = ::getpid();
  pid_ = ::fork();
  if (pid_ == 0) {
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != test) ::_exit(98);
    ::signal(SIGPIPE, SIG_DFL);
    ::dup2(in[0], 0);
    ::dup2(out[1], 1);
    ::dup2(err[1], 2);
    ::execvp(argv[0], argv.data());
    ::_exit(127);
  }
  ::setpgid(pid_, pid_);  // whoever of the two comes first
  for (const int descriptor : {in[0], out[1], err[1]}) ::close(descriptor);
  input_ = in[1];
  output_ = out[0];
  errors_ = err[0];
  ::fcntl(errors_, F_SETFL, O_NONBLOCK);
}

Process::~Process() {
  ::kill(-pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
  shut(input_);
  shut(output_);
  shut(errors_);
}

void Process::write(const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const auto count = ::write(input_, text.data() + done, text.size() - done);
    if (count <= 0) return;
    done += static_cast<std::size_t>(count);
  }
}

void Process::close_input() {
  shut(input_);
}
void Process::close_output() {
  shut(output_);
}
void Process::signal(int number) const {
  ::kill(pid_, number);
}

bool Process::has_settled() const {
  const auto resting = [this] {
    std::ifstream file("/proc/" + std::to_string(pid_) + "/stat");
    std::string text;
    std::getline(file, text);
    return text.find(") S ") != text.npos;
  };
  const auto all_read = [this] {
    int unread = 0;
    return ::ioctl(input_, FIONREAD, &unread) == 0 && unread == 0;
  };
  for (const auto deadline = Clock::now() + kPatience; Clock::now() < deadline; ::usleep(1000)) {
    if (all_read() && resting()) return true;
  }
  return false;
}

bool Process::fill(Clock::time_point deadline) {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
  pollfd wanted{output_, POLLIN, 0};
  if (left <= 0 || ::poll(&wanted, 1, static_cast<int>(left)) <= 0) return false;
  return read_some(output_, pending_);
}

std::optional<std::string> Process::line(std::chrono::seconds patience) {
  const auto deadline = Clock::now() + patience;
  while (true) {
    const auto end = pending_.find('\n');
    if (end != pending_.npos) {
      auto text = pending_.substr(0, end);
      pending_.erase(0, end + 1);
      return text;
    }
    if (!fill(deadline)) return std::nullopt;
  }
}

std::optional<std::string> Process::line_with(const std::string& part) {
  const auto deadline = Clock::now() + kPatience;
  while (Clock::now() < deadline) {
    auto text = line();
    if (!text || text->find(part) != text->npos) return text;
  }
  return std::nullopt;
}

int Process::exit_code(std::chrono::seconds patience) {
  const auto deadline = Clock::now() + patience;
  while (!code_ && Clock::now() < deadline) {
    siginfo_t ended{};
    // Its standard error ends with it: waiting for that needs no polling of the process.
    pollfd wanted{errors_, POLLIN, 0};
    ::poll(&wanted, 1, 20);
    read_some(errors_, error_text_);
    // It stays a zombie, so that its process group keeps its number.
    const int waited = ::waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT);
    if (waited == 0 && ended.si_pid == pid_)
      code_ = ended.si_code == CLD_EXITED ? ended.si_status : 128 + ended.si_status;
  }
  return code_.value_or(-1);
}

std::string Process::errors() {
  while (read_some(errors_, error_text_)) continue;
  return error_text_;
}

long Process::resident_kilobytes() const {
  std::ifstream file("/proc/" + std::to_string(pid_) + "/status");
  for (std::string text; std::getline(file, text);) {
    if (text.rfind("VmRSS:", 0) != 0) continue;
    const auto digits = text.find_first_of("0123456789");
    long kilobytes = -1;
    std::from_chars(text.data() + digits, text.data() + text.size(), kilobytes);
    return kilobytes;
  }
  return -1;
}

long Process::open_descriptors() const {
  const std::filesystem::directory_iterator all("/proc/" + std::to_string(pid_) + "/fd");
  return std::distance(begin(all), end(all));
}

std::chrono::milliseconds Process::processor_time() const {
  std::ifstream file("/proc/" + std::to_string(pid_) + "/stat");
  std::string text;
  std::getline(file, text);
  // The name may have spaces; utime and stime are the 12th and 13th word after it.
  std::istringstream words(text.substr(text.rfind(')') + 1));
  std::string skipped;
  for (int i = 0; i < 11; ++i) words >> skipped;
  long user = 0, system = 0;
  words >> user >> system;
  return std::chrono::milliseconds(1000 * (user + system) / ::sysconf(_SC_CLK_TCK));
}

Outcome run_to_end(std::vector<std::string> arguments, const std::string& input) {
  Process process(std::move(arguments));
  process.write(input);
  process.close_input();
  Outcome outcome;
  constexpr auto kLong = std::chrono::minutes(10);
  while (const auto text = process.line(kLong)) outcome.output += *text + "\n";
  outcome.code = process.exit_code(kLong);
  outcome.errors = process.errors();
  return outcome;
}

}  // namespace rubicon::support
