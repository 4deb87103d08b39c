#pragma once

#include <memory>
#include <string>

#include "base/log.h"
#include "base/scheduler.h"
#include "tuples/dds/dds_ecology.h"

namespace rubicon::tuples::dds {

/// Takes what Cyclone says of errors and warnings, on whatever thread, to our log: each kind at most once a minute. One
/// at a time a process has its words; the latest made. Without it they would stand on standard error, for every packet.
class CycloneLog {
 public:
  CycloneLog(Scheduler& scheduler, DdsEcology::Post post, base::LogSink& log);
  ~CycloneLog();
  CycloneLog(const CycloneLog&) = delete;
  CycloneLog& operator=(const CycloneLog&) = delete;

  /// While it lives, what Cyclone says on this thread is put here instead.
  class Ear {
   public:
    Ear();
    ~Ear();
    Ear(const Ear&) = delete;
    Ear& operator=(const Ear&) = delete;
    std::string heard;  ///< sentences, joined by `; `
  };

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace rubicon::tuples::dds
