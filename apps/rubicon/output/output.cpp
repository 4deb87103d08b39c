#include "apps/rubicon/output/output.h"

#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace rubicon::cli {

int exit_code_of(std::string_view state) {
  constexpr std::array<std::pair<std::string_view, int>, 10> kCodes{{{"confirmed", kGood},
                                                                     {"assumed", kGood},
                                                                     {"applied", kGood},
                                                                     {"refused", kRefused},
                                                                     {"failed", kNotDone},
                                                                     {"timed-out", kTimedOut},
                                                                     {"expired", kExpired},
                                                                     {"superseded", kSuperseded},
                                                                     {"no-such-owner", kNotThere},
                                                                     {"no-such-tuple", kNotThere}}};
  for (const auto& [word, code] : kCodes) {
    if (word == state) return code;
  }
  return kFailed;
}

namespace {

/// Buffered bytes; more are written at once.
constexpr std::size_t kMaxWaiting = 64 * 1024;

/// Of the one Kept, while there is one.
std::string* kept_errors = nullptr;

void keep(std::string& kept, std::string_view text) {
  kept += text.substr(0, Kept::kMaxByteCount - std::min(Kept::kMaxByteCount, kept.size()));
}

}  // namespace

Output::Output(int descriptor) : descriptor_(descriptor), terminal_(::isatty(descriptor) == 1) {
  if (!terminal_) return;
  winsize size{};
  const bool known = ::ioctl(descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  width_ = known ? size.ws_col : 80;
  const auto* none = std::getenv("NO_COLOR");
  colour_ = !(none && *none != '\0');
}

void Output::write(std::string_view text) {
  if (kept_) return keep(*kept_, text);
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

Kept::Kept(Output& out) : out_(out) {
  out.flush();
  out.kept_ = kept_errors = &text_;
}

Kept::~Kept() {
  out_.kept_ = kept_errors = nullptr;
}

void print_error(std::string_view text) {
  if (kept_errors) return keep(*kept_errors, std::string(text) + "\n");
  std::fprintf(stderr, "rubicon: %.*s\n", static_cast<int>(text.size()), text.data());
}

int ended(Output& out, int code) {
  out.flush();
  if (out.error().empty()) return code;
  print_error("standard output: " + out.error());
  return code == kGood ? kFailed : code;
}

}  // namespace rubicon::cli
