#include "support/terminal.h"

#include <poll.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utmp.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>

namespace rubicon::support {

namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kScreenPatience = std::chrono::minutes(1);
constexpr std::size_t kMaxRows = 200, kMaxColumns = 400;

std::size_t character_length(char first) {
  const auto byte = static_cast<unsigned char>(first);
  if (byte < 0xc0) return 1;
  return byte < 0xe0 ? 2 : byte < 0xf0 ? 3 : 4;
}

/// Where the last byte of the sequence stands that begins at `at` (ECMA-48, 5.4), or will stand.
std::size_t sequence_end(const std::string& bytes, std::size_t at) {
  auto end = at + 1;
  if (end >= bytes.size() || bytes[end] != '[') return end;
  do ++end;
  while (end < bytes.size() && (bytes[end] < 0x40 || bytes[end] > 0x7e));
  return end;
}

}  // namespace

Terminal::Terminal(std::vector<std::string> arguments, int rows, int columns)
    : height_(static_cast<std::size_t>(rows)),
      width_(static_cast<std::size_t>(columns)),
      cells_(kMaxRows, std::vector<std::string>(kMaxColumns, " ")) {
  std::vector<char*> argv;
  for (auto& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  winsize size{static_cast<unsigned short>(rows), static_cast<unsigned short>(columns), 0, 0};
  if (::openpty(&master_, &slave_, nullptr, nullptr, &size) != 0) return;
  ::tcgetattr(slave_, &before_);
  pid_ = ::fork();
  if (pid_ == 0) {
    ::close(master_);
    ::login_tty(slave_);
    ::setenv("TERM", "xterm-256color", 1);
    ::execvp(argv[0], argv.data());
    ::_exit(127);
  }
}

Terminal::~Terminal() {
  if (pid_ > 0) {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  ::close(master_);
  ::close(slave_);
}

void Terminal::type(const std::string& keys) const {
  for (std::size_t done = 0; done < keys.size();) {
    const auto count = ::write(master_, keys.data() + done, keys.size() - done);
    if (count <= 0) return;
    done += static_cast<std::size_t>(count);
  }
}

void Terminal::resize(int rows, int columns) {
  height_ = static_cast<std::size_t>(rows);
  width_ = static_cast<std::size_t>(columns);
  const winsize size{static_cast<unsigned short>(rows), static_cast<unsigned short>(columns), 0, 0};
  ::ioctl(master_, TIOCSWINSZ, &size);
}

void Terminal::signal(int number) const {
  ::kill(pid_, number);
}

bool Terminal::read_some() {
  pollfd wanted{master_, POLLIN, 0};
  if (::poll(&wanted, 1, 50) <= 0) return false;
  std::array<char, 65536> buffer;
  const auto count = ::read(master_, buffer.data(), buffer.size());
  if (count <= 0) return false;
  put({buffer.data(), static_cast<std::size_t>(count)});
  return true;
}

bool Terminal::has_ended() const {
  siginfo_t ended{};
  const auto id = static_cast<id_t>(pid_);
  return pid_ <= 0 || (::waitid(P_PID, id, &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid == pid_);
}

bool Terminal::shows(const std::function<bool()>& wanted) {
  const auto end = Clock::now() + kScreenPatience;
  while (Clock::now() < end) {
    while (read_some()) continue;
    if (wanted()) return true;
    if (has_ended() && !read_some()) return wanted();
  }
  return false;
}

bool Terminal::shows(const std::string& text) {
  return shows([&] { return this->text().find(text) != std::string::npos; });
}

std::vector<std::string> Terminal::rows() const {
  std::vector<std::string> all;
  for (std::size_t row = 0; row < height_; ++row) {
    std::string line;
    for (std::size_t column = 0; column < width_; ++column) line += cells_[row][column];
    line.erase(line.find_last_not_of(' ') + 1);
    all.push_back(std::move(line));
  }
  return all;
}

std::string Terminal::text() const {
  std::string all;
  for (const auto& row : rows()) all += row + "\n";
  return all;
}

bool Terminal::is_as_before() const {
  termios now{};
  return ::tcgetattr(slave_, &now) == 0 && now.c_lflag == before_.c_lflag && now.c_iflag == before_.c_iflag;
}

int Terminal::exit_code() {
  const auto end = Clock::now() + kScreenPatience;
  while (pid_ > 0 && Clock::now() < end) {
    read_some();
    int status = 0;
    if (::waitpid(pid_, &status, WNOHANG) != pid_) continue;
    pid_ = -1;
    while (read_some()) continue;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  return -1;
}

void Terminal::put(const std::string& bytes) {
  bytes_ += bytes;
  pending_ += bytes;
  std::size_t at = 0;
  while (at < pending_.size()) {
    const char c = pending_[at];
    if (c == '\x1b') {
      const auto end = sequence_end(pending_, at);
      if (end >= pending_.size()) break;
      sequence(pending_.substr(at + 1, end - at - 1), pending_[end]);
      at = end + 1;
    } else if (c == '\r' || c == '\n') {
      column_ = 0;
      row_ += c == '\n' && row_ + 1 < height_ ? 1 : 0;
      ++at;
    } else {
      const auto length = character_length(c);
      if (at + length > pending_.size()) break;
      if (row_ < kMaxRows && column_ < kMaxColumns) cells_[row_][column_++] = pending_.substr(at, length);
      at += length;
    }
  }
  pending_.erase(0, at);
}

void Terminal::sequence(const std::string& parameters, char last) {
  if (last == 'J') {
    for (auto& row : cells_) row.assign(kMaxColumns, " ");
  } else if (last == 'K') {  // to the end of the line
    if (row_ < kMaxRows && column_ < kMaxColumns)
      std::fill(cells_[row_].begin() + static_cast<std::ptrdiff_t>(column_), cells_[row_].end(), " ");
  } else if (last == 'H') {
    row_ = column_ = 0;
    if (parameters.size() < 2) return;
    row_ = std::stoul(parameters.substr(1)) - 1;
    if (const auto semicolon = parameters.find(';'); semicolon != parameters.npos)
      column_ = std::stoul(parameters.substr(semicolon + 1)) - 1;
  }
}

}  // namespace rubicon::support
