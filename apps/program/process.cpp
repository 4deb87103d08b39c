#include "apps/program/process.h"

#include <poll.h>
#include <spdlog/logger.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <utility>

#include "base/text.h"

namespace rubicon::program {

namespace {

spdlog::level::level_enum to_spdlog(base::LogLevel level) {
  switch (level) {
    case base::LogLevel::kDebug: return spdlog::level::debug;
    case base::LogLevel::kInfo: return spdlog::level::info;
    case base::LogLevel::kWarning: return spdlog::level::warn;
    case base::LogLevel::kError: return spdlog::level::err;
  }
  return spdlog::level::err;
}

/// What a pipe that has room takes at once (POSIX: PIPE_BUF), less what stands before it.
constexpr std::size_t kMaxLine = 3500;

/// One log line stays one line, whatever a device put into its name.
/// A pipe without a reader must not stop the loop.
bool has_room(int descriptor) {
  pollfd wanted{descriptor, POLLOUT, 0};
  return ::poll(&wanted, 1, 0) != 0;
}

}  // namespace

struct SpdlogSink::Impl {
  std::uint64_t lost = 0;  ///< lines since the last one that was written
  spdlog::logger logger{"rubicon", std::make_shared<spdlog::sinks::stderr_color_sink_st>()};
};

SpdlogSink::SpdlogSink(const std::string& level) : impl_(std::make_unique<Impl>()) {
  impl_->logger.set_pattern("%Y-%m-%dT%H:%M:%S.%e%z %^%l%$ %v");
  impl_->logger.set_level(spdlog::level::from_str(level));
}
SpdlogSink::~SpdlogSink() = default;

void SpdlogSink::write(base::LogLevel level, std::string_view who, std::string_view text) {
  if (!impl_->logger.should_log(to_spdlog(level))) return;
  if (!has_room(STDERR_FILENO)) {
    ++impl_->lost;
    return;
  }
  if (impl_->lost > 0)
    impl_->logger.warn("log: {} lines were lost because standard error was not read", std::exchange(impl_->lost, 0));
  impl_->logger.log(to_spdlog(level), "{}: {}", who, base::one_line(text).substr(0, kMaxLine));
}

namespace {

constexpr unsigned kSeconds = 2;
volatile std::sig_atomic_t exit_code = 0;

}  // namespace

void end_within_seconds(int code) {
  exit_code = code;
  struct sigaction action {};
  action.sa_handler = [](int) { ::_exit(exit_code); };
  ::sigaction(SIGALRM, &action, nullptr);
  ::alarm(kSeconds);
}

void end_whenever_done() {
  ::alarm(0);
}

}  // namespace rubicon::program
