#pragma once

#include <memory>
#include <string>

#include "base/log.h"

namespace rubicon::program {

/// Log lines on standard error. `level` is one of debug, info, warning, error, off.
class SpdlogSink final : public base::LogSink {
 public:
  explicit SpdlogSink(const std::string& level);
  ~SpdlogSink() override;
  void write(base::LogLevel level, std::string_view who, std::string_view text) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::program
