#include "apps/rubicon/output.h"

#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "apps/rubicon/exit_codes.h"

namespace rubicon::cli {

namespace {

/// Buffered bytes; more are written at once.
constexpr std::size_t kMaxWaiting = 64 * 1024;

}  // namespace

Output::Output(int descriptor) : descriptor_(descriptor), terminal_(::isatty(descriptor) == 1) {
  if (!terminal_) return;
  winsize size{};
  const bool known = ::ioctl(descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  width_ = known ? size.ws_col : 80;
  height_ = known && size.ws_row > 0 ? size.ws_row : 24;
  const auto* none = std::getenv("NO_COLOR");
  colour_ = !(none && *none != '\0');
}

void Output::write(std::string_view text) {
  waiting_ += text;
  if (waiting_.size() > kMaxWaiting) flush();
}

void Output::line(std::string_view text) {
  write(text);
  write("\n");
}

void Output::flush() {
  std::string_view left = waiting_;
  while (!left.empty() && !broken_) {
    const auto count = ::write(descriptor_, left.data(), left.size());
    if (count >= 0) {
      left.remove_prefix(static_cast<std::size_t>(count));
    } else if (errno == EINTR) {
      break;  // a signal that may end the program: the caller checks
    } else if (errno != EAGAIN) {
      broken_ = true;
      if (errno != EPIPE) error_ = std::strerror(errno);
    }
  }
  waiting_ = broken_ ? std::string() : std::string(left);
}

bool Output::broken() {
  pollfd reader{descriptor_, 0, 0};
  if (!broken_ && ::poll(&reader, 1, 0) == 1 && (reader.revents & (POLLERR | POLLNVAL)) != 0) broken_ = true;
  return broken_;
}

void print_error(std::string_view text) {
  std::fprintf(stderr, "rubicon: %.*s\n", static_cast<int>(text.size()), text.data());
}

int ended(Output& out, int code) {
  out.flush();
  if (out.error().empty()) return code;
  print_error("standard output: " + out.error());
  return code == kGood ? kFailed : code;
}

}  // namespace rubicon::cli
