#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "base/log.h"
#include "base/scheduler.h"
#include "tuples/dds/dds_ecology.h"
#include "tuples/dds/entity.h"

namespace rubicon::tuples::dds {

/// Wakes the loop from the threads of DDS: however many events there are, at most one posted call is pending.
class Signal {
 public:
  /// What has news. kWriter: a reader was matched, so that frames can be sent.
  enum Source : unsigned { kPresence = 1, kInterests = 2, kFrames = 4, kWriter = 8 };

  /// `call` receives the sources that raised the signal.
  Signal(DdsEcology::Post post, std::function<void(unsigned sources)> call);
  ~Signal();
  Signal(const Signal&) = delete;
  Signal& operator=(const Signal&) = delete;

  /// For entities that are deleted before the signal.
  const dds_listener_t* listener(Source source) const;
  void raise(Source source);
  /// What the listeners use, for entities that are deleted after the signal.
  std::shared_ptr<const void> used() const;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

/// Redirects errors and warnings of Cyclone DDS, from any thread, to our log: at most one line per kind and minute.
/// Without it Cyclone would write to standard error for each packet. Cyclone has one sink per process: the latest
/// CycloneLog that lives receives the messages.
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
  static void use_latest();
  std::shared_ptr<Shared> shared_;
};

}  // namespace rubicon::tuples::dds
