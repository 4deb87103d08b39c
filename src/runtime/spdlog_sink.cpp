#include "runtime/spdlog_sink.h"

#include <spdlog/logger.h>
#include <spdlog/sinks/stdout_color_sinks.h>

namespace rubicon::runtime {

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

/// One log line stays one line, whatever a device put into its name.
std::string one_line(std::string_view text) {
  std::string out(text);
  for (auto& c : out) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return out;
}

}  // namespace

struct SpdlogSink::Parts {
  spdlog::logger logger{"rubicon", std::make_shared<spdlog::sinks::stderr_color_sink_st>()};
};

SpdlogSink::SpdlogSink(const std::string& level) : parts_(std::make_unique<Parts>()) {
  parts_->logger.set_pattern("%Y-%m-%dT%H:%M:%S.%e %^%l%$ %v");
  parts_->logger.set_level(spdlog::level::from_str(level));
}
SpdlogSink::~SpdlogSink() = default;

void SpdlogSink::write(base::LogLevel level, std::string_view who, std::string_view text) {
  parts_->logger.log(to_spdlog(level), "{}: {}", who, one_line(text));
}

}  // namespace rubicon::runtime
