#pragma once

#include <memory>
#include <string>

#include "base/log.h"
#include "base/scheduler.h"
#include "tuples/dds/dds_ecology.h"

namespace rubicon::tuples::dds {

/// Redirects errors and warnings of Cyclone DDS, from any thread, to our log: at most one line per kind and minute.
/// Without it Cyclone would write to standard error for each packet. Cyclone has one sink per process: the latest
/// CycloneLog receives the messages.
class CycloneLog {
 public:
  CycloneLog(Scheduler& scheduler, DdsEcology::Post post, base::LogSink& log);
  ~CycloneLog();
  CycloneLog(const CycloneLog&) = delete;
  CycloneLog& operator=(const CycloneLog&) = delete;

  /// While it lives, messages of Cyclone on this thread are collected here instead.
  class Capture {
   public:
    Capture();
    ~Capture();
    Capture(const Capture&) = delete;
    Capture& operator=(const Capture&) = delete;
    std::string text;  ///< messages, joined by `; `
  };

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace rubicon::tuples::dds
