#pragma once

#include <deque>
#include <utility>

#include "base/scheduler.h"
#include "transport/transports.h"

namespace rubicon::transport {

/// Runs each job in a turn of its own on the loop: time can be virtual. It can be held, as a disk that does not answer.
class MemoryWorker final : public Worker {
 public:
  explicit MemoryWorker(Scheduler& scheduler) : scheduler_(scheduler) {}
  ~MemoryWorker() override {
    while (!jobs_.empty()) run_one();
  }

  void run(Job job) override {
    jobs_.push_back(std::move(job));
    lifetime_.post(scheduler_, [this] { run_next(); });
  }
  /// Until release() no job runs.
  void hold() { held_ = true; }
  void release() {
    held_ = false;
    for (std::size_t i = 0; i < jobs_.size(); ++i) lifetime_.post(scheduler_, [this] { run_next(); });
  }
  std::size_t waiting() const { return jobs_.size(); }

 private:
  void run_next() {
    if (!held_ && !jobs_.empty()) run_one();
  }
  void run_one() {
    const auto job = std::move(jobs_.front());
    jobs_.pop_front();
    job();
  }

  Scheduler& scheduler_;
  std::deque<Job> jobs_;
  bool held_ = false;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::transport
