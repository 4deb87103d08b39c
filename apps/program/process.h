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

/// What --version prints: `PROGRAM VERSION`, the commit that was built, and each library that this process has loaded,
/// with its version: of the loaded library if the library reports it, else of the build. Ends without a line feed.
std::string version_text(const char* program);

/// From now on the process ends within two seconds with this code, whatever its destructors do: Cyclone DDS waits for
/// good for a thread that nothing wakes once the address of its interface is gone (dds_delete, 0.10.2). May be called
/// by a signal handler. The last call counts.
void end_within_seconds(int code);
/// It may take longer again.
void end_whenever_done();

}  // namespace rubicon::program
