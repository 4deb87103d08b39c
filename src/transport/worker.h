#pragma once

#include <functional>
#include <memory>
#include <string>

#include "rubicon/result.hpp"

namespace rubicon::transport {

/// Does one job after the other apart from the loop, for work that waits for a disk or computes long.
class Worker {
 public:
  using Job = std::function<void()>;

  /// Runs the jobs that wait, then ends.
  virtual ~Worker() = default;
  /// Appends a job; it runs on the worker's thread, and posts its result to the loop. The queue has no bound: the
  /// caller counts what it gave.
  virtual void run(Job job) = 0;
};

/// A thread of its own, of low priority. `name` shows it in lists of threads: at most 15 characters. kIo: the system
/// has no room for one more.
Result<std::unique_ptr<Worker>> start_worker(const std::string& name);

}  // namespace rubicon::transport
